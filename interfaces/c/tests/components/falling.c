// Grains in C, for the test of the interface: listed spheres that fall and follow their loads, without contacts.

#include <tremie.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST 64

typedef struct {
  uint64_t count;
  double step;  // [s]
  double gravity[3];
  double mass[MOST];
  tremie_body_state bodies[MOST];
  tremie_body_event events[MOST];
  int are_told;  // whether the events of the start were asked for
} falling;

// Reads the spheres of the first set; gives how many there are.
static uint64_t read_spheres(const tremie_setup *setup, falling *grains) {
  char path[96];
  double density = 0, diameter = 0;
  tremie_setup_number(setup, "scene.bodies[0].density", &density);
  for (uint64_t k = 0; k < MOST; ++k) {
    snprintf(path, sizeof path, "scene.bodies[0].placement.listed[%u].diameter", (unsigned)k);
    if (tremie_setup_number(setup, path, &diameter) != 0) return k;
    tremie_body_state *body = &grains->bodies[k];
    body->id = k;
    body->orientation[3] = 1;
    for (unsigned axis = 0; axis < 3; ++axis) {
      snprintf(path, sizeof path, "scene.bodies[0].placement.listed[%u].position[%u]", (unsigned)k, axis);
      tremie_setup_number(setup, path, &body->position[axis]);
    }
    grains->mass[k] = density * acos(-1.0) / 6 * diameter * diameter * diameter;
    tremie_body_event *event = &grains->events[k];
    event->id = k;
    event->kind = tremie_body_event_ADDED;
    event->shape = tremie_body_event_SPHERE;
    event->motion = tremie_body_event_FREE;
    event->mass = grains->mass[k];
    event->size[0] = diameter / 2;
  }
  return MOST;
}

static int describe(const tremie_setup *setup, tremie_description *description) {
  falling grains;
  memset(&grains, 0, sizeof grains);
  const uint64_t count = read_spheres(setup, &grains);
  if (count == 0) return tremie_problem("scene.bodies", "no spheres are listed", "list some");
  tremie_describe_bodies(description, count);
  tremie_describe_step(description, 1e-4, "chosen");
  tremie_describe_signal(description, "lowest", "m", "height of the lowest centre");
  tremie_describe_state(description, 1);
  return 0;
}

static void *create(const tremie_setup *setup) {
  falling *grains = calloc(1, sizeof *grains);
  if (grains == NULL) {
    tremie_problem("scene.bodies", "there is no memory for them", NULL);
    return NULL;
  }
  grains->count = read_spheres(setup, grains);
  grains->step = tremie_setup_step(setup);
  for (int axis = 0; axis < 3; ++axis) {
    char path[32];
    snprintf(path, sizeof path, "scene.gravity[%d]", axis);
    tremie_setup_number(setup, path, &grains->gravity[axis]);
  }
  return grains;
}

static size_t events(void *self, const tremie_body_event **at) {
  falling *grains = self;
  *at = grains->events;
  const size_t count = grains->are_told ? 0 : grains->count;
  grains->are_told = 1;
  return count;
}

static int state(void *self, tremie_body_state *bodies, size_t count) {
  falling *grains = self;
  if (count != grains->count) return tremie_fail("another number of bodies is asked for than there are");
  memcpy(bodies, grains->bodies, count * sizeof *bodies);
  return 0;
}

static int advance(void *self, uint32_t substeps, const tremie_load *loads, size_t count) {
  falling *grains = self;
  for (uint32_t substep = 0; substep < substeps; ++substep) {
    for (uint64_t k = 0; k < grains->count; ++k) {
      tremie_body_state *body = &grains->bodies[k];
      for (int axis = 0; axis < 3; ++axis) {
        const double force = k < count ? loads[k].force[axis] : 0;
        body->velocity[axis] += grains->step * (grains->gravity[axis] + force / grains->mass[k]);
        body->position[axis] += grains->step * body->velocity[axis];
      }
    }
  }
  return 0;
}

static void signals(void *self, double *values, size_t count) {
  const falling *grains = self;
  if (count < 1) return;
  values[0] = grains->bodies[0].position[2];
  for (uint64_t k = 1; k < grains->count; ++k) values[0] = fmin(values[0], grains->bodies[k].position[2]);
}

static int exchange_state(void *self, tremie_state *state) {
  falling *grains = self;
  for (uint64_t k = 0; k < grains->count; ++k) {
    char name[32];
    snprintf(name, sizeof name, "position%u", (unsigned)k);
    if (tremie_state_doubles(state, name, grains->bodies[k].position, 3) != 0) return 1;
    snprintf(name, sizeof name, "velocity%u", (unsigned)k);
    if (tremie_state_doubles(state, name, grains->bodies[k].velocity, 3) != 0) return 1;
  }
  return 0;
}

int main(void) {
  const tremie_grains grains = {"falling 1", describe, create,         events, state,
                                advance,     signals,  exchange_state, free};
  return tremie_grains_main(&grains);
}
