// Tremie for C and C++: a component is a table of functions, and `main` is one call.
//
// All values are in SI units and in the world frame. Arrays that a function gets are the memory that
// the processes of a run share: they are valid during the call alone.
//
// A function that can fail gives 0 if it has not. Before it gives anything else it says why, by
// `tremie_fail` (a sentence: what, where, found, expected, what to do). In `describe` and `create`
// wrong input is said by `tremie_problem`, once for each wrong key.
//
// Made by cbindgen from interfaces/c; a test compares.

#pragma once

#include <stddef.h>
#include <stdint.h>

// A state on its way out of a component, or back into it. Opaque.
typedef struct tremie_state tremie_state;

// What a component says of itself before a run is planned. Opaque.
typedef struct tremie_description tremie_description;

// The run as a component knows it. Opaque.
typedef struct tremie_setup tremie_setup;

// A body that appears or disappears at the end of a window. 64 bytes.
//
// The `events` channel carries the list of each window, even an empty one, before the state of
// the same window. The initial bodies are the first list (number 0, in the start exchange).
typedef struct {
  // Id of the body.
  uint64_t id;
  // Kind of event: [`BodyEvent::ADDED`] or [`BodyEvent::REMOVED`].
  uint32_t kind;
  // Shape of an added body: [`BodyEvent::SPHERE`], [`BodyEvent::PART`],
  // [`BodyEvent::POLYHEDRON`] or [`BodyEvent::CYLINDER`].
  uint32_t shape;
  // Motion of an added body: [`BodyEvent::FREE`], [`BodyEvent::FIXED`],
  // [`BodyEvent::PRESCRIBED`] or [`BodyEvent::SLIDER`].
  uint32_t motion;
  // Index into the scene's list of body sets that the body came from.
  uint32_t set;
  // Mass [kg]; 0 for a part whose motion is prescribed.
  double mass;
  // Size of the shape [m]: `[radius, 0, 0]` for a sphere; for a part the radius about its
  // reference point that holds it; for a polyhedron that radius, and the diameter of a sphere of
  // equal volume; for a cylinder its radius and its length.
  double size[3];
  // Index into the scene's list of parts, for a part, or of shapes, for a polyhedron; else 0.
  uint64_t table;
} tremie_body_event;
// The body is there from this window's end on.
#define tremie_body_event_ADDED 1
// The body is gone from this window's end on.
#define tremie_body_event_REMOVED 2
// A sphere.
#define tremie_body_event_SPHERE 1
// A part of the scene, its surface in the body's frame.
#define tremie_body_event_PART 2
// A convex polyhedron of a shape of the scene.
#define tremie_body_event_POLYHEDRON 3
// A cylinder across the plane of a plane scene.
#define tremie_body_event_CYLINDER 4
// Moves under forces.
#define tremie_body_event_FREE 0
// Never moves.
#define tremie_body_event_FIXED 1
// Moves as the scene says, whatever the forces.
#define tremie_body_event_PRESCRIBED 2
// Moves along one axis under forces.
#define tremie_body_event_SLIDER 3

// Pose and velocity of a body, world frame, SI units. 112 bytes.
//
// The `state` channel carries one for each living body, sorted by id.
typedef struct {
  // Id of the body, never reused in a run.
  uint64_t id;
  // Reference point (a sphere's centre) [m].
  double position[3];
  // Unit quaternion `(x, y, z, w)` from body frame to world frame.
  double orientation[4];
  // Velocity of the reference point [m/s].
  double velocity[3];
  // Angular velocity [rad/s].
  double angular_velocity[3];
} tremie_body_state;

// Force on a body and torque about its reference point, world frame. 56 bytes.
//
// The `load` channel carries one for each body of the state that it answers, in the same order.
// Loads of a fluid include buoyancy; grains always apply the full weight.
typedef struct {
  // Id of the body.
  uint64_t id;
  // Force [N].
  double force[3];
  // Torque about the reference point [N·m].
  double torque[3];
} tremie_load;

// A fluid: takes poses of bodies, gives the loads on them. `bodies` and `loads` have the same bodies in the same
// order (ascending ids). `self` is what `create` gave. All functions run on one thread.
typedef struct {
  // Name and version, for the log. The name also tells states of checkpoints from another's.
  const char *program;
  // Checks scene and parameters, and says what the fluid needs. Cheap.
  int (*describe)(const tremie_setup*, tremie_description*);
  // Makes the fluid for the assigned step; null if it cannot.
  void *(*create)(const tremie_setup*);
  // Bodies that appear or disappear, effective with the next bodies.
  int (*events)(void*, const tremie_body_event*, size_t);
  // Looks at the bodies at time zero, lets no time pass, writes the loads on them.
  int (*start)(void*, const tremie_body_state*, tremie_load*, size_t);
  // Advances through a window in so many substeps, and writes the mean loads, buoyancy included.
  int (*advance)(void*, uint32_t, const tremie_body_state*, tremie_load*, size_t);
  // Writes the values of the signals, in the order of the description; null if there are none.
  void (*signals)(void*, double*, size_t);
  // Names the state, to keep it and to put it back; null if there is none.
  int (*exchange_state)(void*, tremie_state*);
  // Ends the fluid.
  void (*destroy)(void*);
} tremie_fluid;

// Grains: take the loads on bodies, give their poses and the events of their lives. `self` is what `create` gave.
// All functions run on one thread.
typedef struct {
  // Name and version, for the log. The name also tells states of checkpoints from another's.
  const char *program;
  // Checks scene and parameters, and says what the grains need. Cheap.
  int (*describe)(const tremie_setup*, tremie_description*);
  // Makes the grains for the assigned step; null if it cannot.
  void *(*create)(const tremie_setup*);
  // Points to the bodies that appeared or disappeared at the last window's end, at first to all, and gives
  // their number. They stay the component's own, and valid until the next call.
  size_t (*events)(void*, const tremie_body_event**);
  // Writes the states of all living bodies, in ascending order of their ids.
  int (*state)(void*, tremie_body_state*, size_t);
  // Advances through a window in so many substeps, each under the same loads; none without a fluid.
  int (*advance)(void*, uint32_t, const tremie_load*, size_t);
  // Writes the values of the signals, in the order of the description; null if there are none.
  void (*signals)(void*, double*, size_t);
  // Names the state, to keep it and to put it back; null if there is none.
  int (*exchange_state)(void*, tremie_state*);
  // Ends the grains.
  void (*destroy)(void*);
} tremie_grains;

// A body as an observer sees it.
typedef struct {
  // Pose and velocity.
  tremie_body_state state;
  // Radius of a sphere; of a part, that about its reference point that holds it [m].
  double radius;
  // Mass [kg].
  double mass;
  // Index into the scene's body sets.
  uint32_t set;
  // One of `tremie_body_event`'s shapes.
  uint32_t shape;
  // One of `tremie_body_event`'s motions.
  uint32_t motion;
  // Index into the scene's list of parts, for a part; else 0.
  uint32_t part;
} tremie_frame_body;

// An observer: sees frames, and changes nothing. `self` is what `create` gave. All functions run on one thread.
typedef struct {
  // Name and version, for the log.
  const char *program;
  // Checks the parameters; nothing is opened yet.
  int (*describe)(const tremie_setup*, tremie_description*);
  // Opens outputs; null if it cannot.
  void *(*create)(const tremie_setup*);
  // All bodies at one moment: sender, window, simulated time [s], bodies. Null if they are not wanted.
  int (*bodies)(void*, const char*, uint64_t, double, const tremie_frame_body*, size_t);
  // A signal of a component at one moment: sender, window, simulated time [s], name, value. Null if they are
  // not wanted.
  int (*signal)(void*, const char*, uint64_t, double, const char*, double);
  // The run is over, and every frame was delivered.
  int (*close)(void*);
  // Ends the observer.
  void (*destroy)(void*);
} tremie_observer;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Says why the function that calls it fails: a sentence. Gives 1, for `return tremie_fail("...");`.
//
// # Safety
// `why` ends with a zero.
int tremie_fail(const char *why);

// Says a fault of a user's input, in `describe` and in `create`: the manifest's key, as
// `scene.fluid.viscosity`, or `@cell` of the component's own table; what was found and expected; and a
// remedy, or null. Gives 1.
//
// # Safety
// The texts end with a zero.
int tremie_problem(const char *key,
                   const char *message,
                   const char *help);

// The scene (in SI units) and the component's own table, as one JSON document
// `{"scene": .., "parameters": ..}`. Valid as long as the setup.
//
// # Safety
// `setup` comes from the library.
const char *tremie_setup_json(const tremie_setup *setup);

// Folder of the run's outputs. Valid as long as the setup.
//
// # Safety
// `setup` comes from the library.
const char *tremie_setup_output(const tremie_setup *setup);

// Name of the component in this run. Valid as long as the setup.
//
// # Safety
// `setup` comes from the library.
const char *tremie_setup_component(const tremie_setup *setup);

// Reads the number at a path, as `scene.fluid.density`, `scene.gravity[2]` or `parameters.count`. Gives 0
// if there is one.
//
// # Safety
// `setup` comes from the library, `path` ends with a zero, and `value` can be written.
int tremie_setup_number(const tremie_setup *setup,
                        const char *path,
                        double *value);

// Reads the quantity with its unit at a path of the component's own table, as `parameters.cell`, into SI
// units; `kind` is length, area, volume, time, velocity, angular velocity, acceleration, mass, density,
// viscosity, force, stiffness, dashpot, pressure, temperature, angle or frequency. Gives 0 if there is one.
//
// # Safety
// `setup` comes from the library, the texts end with a zero, and `value` can be written.
int tremie_setup_quantity(const tremie_setup *setup,
                          const char *path,
                          const char *kind,
                          double *value);

// Length of a substep [s]; 0 in `describe`.
//
// # Safety
// `setup` comes from the library.
double tremie_setup_step(const tremie_setup *setup);

// Substeps in a coupling window; 0 in `describe`.
//
// # Safety
// `setup` comes from the library.
uint32_t tremie_setup_substeps(const tremie_setup *setup);

// Length of a coupling window [s]; 0 in `describe`.
//
// # Safety
// `setup` comes from the library.
double tremie_setup_window(const tremie_setup *setup);

// Threads that the component may use.
//
// # Safety
// `setup` comes from the library.
uint32_t tremie_setup_threads(const tremie_setup *setup);

// The longest step that is stable and accurate [s], and what limits it, in a few words. Not called, the
// component takes any.
//
// # Safety
// `description` comes from the library; the text ends with a zero.
void tremie_describe_step(tremie_description *description,
                          double step,
                          const char *limit);

// Number of bodies that grains bring.
//
// # Safety
// `description` comes from the library.
void tremie_describe_bodies(tremie_description *description, uint64_t bodies);

// A scalar that the component reports: name in snake case, SI unit (1 if none), meaning. `signals` gives the
// values in the order of these calls.
//
// # Safety
// `description` comes from the library; the texts end with a zero.
void tremie_describe_signal(tremie_description *description,
                            const char *name,
                            const char *unit,
                            const char *meaning);

// A line for the plan.
//
// # Safety
// `description` comes from the library; the text ends with a zero.
void tremie_describe_note(tremie_description *description, const char *note);

// Something doubtful, with the remedy.
//
// # Safety
// `description` comes from the library; the text ends with a zero.
void tremie_describe_warning(tremie_description *description, const char *warning);

// The component has `exchange_state`; another version whenever that names other things.
//
// # Safety
// `description` comes from the library.
void tremie_describe_state(tremie_description *description, uint32_t version);

// 1 if the state is put back, 0 if it is kept.
//
// # Safety
// `state` comes from the library.
int tremie_state_restores(const tremie_state *state);

// A whole number, as a length for which a component makes room before it names an array. Gives 0, or
// something else for a state that does not fit: then give that back.
//
// # Safety
// `state` comes from the library, the name ends with a zero, `value` can be read and written.
int tremie_state_count(tremie_state *state,
                       const char *name,
                       uint64_t *value);

// Numbers in double precision. Gives 0, or something else for a state that does not fit: then give that back.
//
// # Safety
// `state` comes from the library, the name ends with a zero, and `count` values can be read and written.
int tremie_state_doubles(tremie_state *state,
                         const char *name,
                         double *values,
                         size_t count);

// Whole numbers. Gives 0, or something else for a state that does not fit: then give that back.
//
// # Safety
// `state` comes from the library, the name ends with a zero, and `count` values can be read and written.
int tremie_state_integers(tremie_state *state,
                          const char *name,
                          uint64_t *values,
                          size_t count);

// Takes part in a run as this fluid; gives the exit code of the process.
//
// # Safety
// `table` is whole, and its functions do what it says.
int tremie_fluid_main(const tremie_fluid *table);

// Takes part in a run as these grains; gives the exit code of the process.
//
// # Safety
// `table` is whole, and its functions do what it says.
int tremie_grains_main(const tremie_grains *table);

// Takes part in a run as this observer; gives the exit code of the process.
//
// # Safety
// `table` is whole, and its functions do what it says.
int tremie_observer_main(const tremie_observer *table);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus
