// An observer in C, for the test of the interface: counts what it sees, and writes it down at the end.

#include <tremie.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  FILE *file;
  unsigned frames, bodies, signals;
  double height;  // of the lowest body in the last frame [m]
  double told;    // the same as a signal of the grains tells it [m]
} tally;

static int describe(const tremie_setup *setup, tremie_description *description) {
  (void)setup;
  tremie_describe_note(description, "counts frames");
  return 0;
}

static void *create(const tremie_setup *setup) {
  char path[4096];
  snprintf(path, sizeof path, "%s/tally.txt", tremie_setup_output(setup));
  FILE *file = fopen(path, "w");
  if (file == NULL) {
    tremie_problem("@", "tally.txt cannot be written", "choose another --out");
    return NULL;
  }
  tally *seen = calloc(1, sizeof *seen);
  if (seen != NULL) seen->file = file;
  return seen;
}

static int bodies(void *self, const char *from, uint64_t window, double time, const tremie_frame_body *bodies,
                  size_t count) {
  tally *seen = self;
  (void)from, (void)window, (void)time;
  seen->frames += 1;
  seen->bodies = (unsigned)count;
  for (size_t k = 0; k < count; ++k) {
    const double height = bodies[k].state.position[2];
    if (k == 0 || height < seen->height) seen->height = height;
  }
  return 0;
}

static int signal_of(void *self, const char *from, uint64_t window, double time, const char *name, double value) {
  tally *seen = self;
  (void)window, (void)time;
  seen->signals += 1;
  if (strcmp(from, "grains") == 0 && strcmp(name, "lowest") == 0) seen->told = value;
  return 0;
}

static int close_file(void *self) {
  tally *seen = self;
  fprintf(seen->file, "%u frames of %u bodies, %u signals, lowest %.17g and %.17g\n", seen->frames, seen->bodies,
          seen->signals, seen->height, seen->told);
  const int failed = fclose(seen->file);
  seen->file = NULL;
  return failed == 0 ? 0 : tremie_fail("tally.txt could not be written to its end");
}

static void destroy(void *self) {
  tally *seen = self;
  if (seen->file != NULL) fclose(seen->file);
  free(seen);
}

int main(void) {
  const tremie_observer observer = {"tally 1", describe, create, bodies, signal_of, close_file, destroy};
  return tremie_observer_main(&observer);
}
