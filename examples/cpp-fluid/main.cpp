// A fluid in C++: Stokes drag and buoyancy on spheres, as examples/minimal-fluid does it in Rust.
//
// On each grain act the force F = 3 pi mu d (u - v) - rho_f V g and the torque T = -pi mu d^3 omega
// (Stokes 1851). The fluid's velocity u is constant; no grain feels another through it.

#include <tremie.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <string>
#include <vector>

namespace {

constexpr double pi = 3.14159265358979323846;

struct StokesFluid {
  double density = 0;    // [kg/m3]
  double viscosity = 0;  // [Pa s]
  std::array<double, 3> velocity{};
  std::array<double, 3> gravity{};
  std::map<std::uint64_t, double> diameters;  // of each living grain, by its id [m]
  double largest_drag = 0;                    // [N]
};

// Reads material and gravity; says each problem with the key of the manifest.
bool read(const tremie_setup *setup, StokesFluid &fluid) {
  bool whole = true;
  const auto number = [&](const std::string &key, double &value) {
    if (tremie_setup_number(setup, key.c_str(), &value) != 0) {
      tremie_problem(key.c_str(), "there is no such number", "add a [scene.fluid] table");
      whole = false;
    }
  };
  number("scene.fluid.density", fluid.density);
  number("scene.fluid.viscosity", fluid.viscosity);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string place = "[" + std::to_string(axis) + "]";
    number("scene.fluid.velocity" + place, fluid.velocity[axis]);
    number("scene.gravity" + place, fluid.gravity[axis]);
  }
  return whole;
}

StokesFluid &of(void *self) { return *static_cast<StokesFluid *>(self); }

// Exceptions must not reach the library, which is no C++: they become failures.
template <class Work>
int guarded(Work work) {
  try {
    return work();
  } catch (const std::exception &error) {
    return tremie_fail(error.what());
  }
}

int describe(const tremie_setup *setup, tremie_description *description) {
  StokesFluid fluid;
  if (!read(setup, fluid)) return 1;
  // No step of its own: it takes whatever window the others need.
  tremie_describe_signal(description, "largest_drag", "N", "largest drag on a sphere");
  const std::string note = "Stokes drag, " + std::to_string(fluid.viscosity) + " Pa s";
  tremie_describe_note(description, note.c_str());
  tremie_describe_warning(description, "grains do not feel each other through this fluid");
  // Another number whenever `exchange_state` names other things.
  tremie_describe_state(description, 1);
  return 0;
}

void *create(const tremie_setup *setup) {
  auto *fluid = new StokesFluid;
  if (read(setup, *fluid)) return fluid;
  delete fluid;
  return nullptr;
}

int events(void *self, const tremie_body_event *events, std::size_t count) {
  return guarded([&] {
    auto &diameters = of(self).diameters;
    for (const auto *event = events; event != events + count; ++event) {
      if (event->kind == tremie_body_event_REMOVED) {
        diameters.erase(event->id);
      } else if (event->shape == tremie_body_event_SPHERE) {
        diameters[event->id] = 2 * event->size[0];
      } else {
        return tremie_fail(("body " + std::to_string(event->id) + " is no sphere").c_str());
      }
    }
    return 0;
  });
}

int advance(void *self, std::uint32_t, const tremie_body_state *bodies, tremie_load *loads,
            std::size_t count) {
  return guarded([&] {
    auto &fluid = of(self);
    fluid.largest_drag = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double d = fluid.diameters.at(bodies[k].id);
      const double volume = pi / 6 * d * d * d;
      for (int axis = 0; axis < 3; ++axis) {
        const double slip = fluid.velocity[axis] - bodies[k].velocity[axis];
        const double drag = 3 * pi * fluid.viscosity * d * slip;
        // Buoyancy is part of the load: grains always apply their full weight.
        loads[k].force[axis] = drag - fluid.density * volume * fluid.gravity[axis];
        loads[k].torque[axis] =
            -pi * fluid.viscosity * d * d * d * bodies[k].angular_velocity[axis];
        fluid.largest_drag = std::max(fluid.largest_drag, std::abs(drag));
      }
    }
    return 0;
  });
}

int start(void *self, const tremie_body_state *bodies, tremie_load *loads, std::size_t count) {
  return advance(self, 0, bodies, loads, count);
}

void signals(void *self, double *values, std::size_t) { values[0] = of(self).largest_drag; }

// Names the state once, for keeping it and for putting it back.
int exchange_state(void *self, tremie_state *state) {
  return guarded([&] {
    auto &fluid = of(self);
    std::uint64_t count = fluid.diameters.size();
    if (tremie_state_count(state, "count", &count) != 0) return 1;
    std::vector<std::uint64_t> ids;
    std::vector<double> diameters;
    for (const auto &[id, diameter] : fluid.diameters) {
      ids.push_back(id);
      diameters.push_back(diameter);
    }
    ids.resize(count);
    diameters.resize(count);
    if (tremie_state_integers(state, "ids", ids.data(), count) != 0) return 1;
    if (tremie_state_doubles(state, "diameters", diameters.data(), count) != 0) return 1;
    if (tremie_state_doubles(state, "largest_drag", &fluid.largest_drag, 1) != 0) return 1;
    fluid.diameters.clear();
    for (std::size_t k = 0; k < count; ++k) fluid.diameters[ids[k]] = diameters[k];
    return 0;
  });
}

void destroy(void *self) { delete static_cast<StokesFluid *>(self); }

}  // namespace

int main() {
  const tremie_fluid fluid = {"cpp-fluid 0.1.0", describe, create,         events, start,
                              advance,           signals,  exchange_state, destroy};
  return tremie_fluid_main(&fluid);
}
