// Scenes of the production fluid as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/scene.h"
#include "common/production_fluid/system.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_fluid_inputs {

struct Inputs {
  production_fluid::Scene scene;
  production_fluid::System<float> system;  // of the pressure, by the serial text
};
std::shared_ptr<const Inputs> inputs(const std::string& path);

// The scene's velocity, with padding that shows whether a kernel has written it.
production_fluid::Faces<float> velocity(const Inputs& in);

// The settings that a step has by default.
inline const production_fluid::PressureSettings pressure_settings = production_fluid::Model{}.pressure;

// The solution of the system by the serial text.
std::shared_ptr<const Array<double>> pressure(const std::string& path);

double cells_of(const Inputs& in);         // of the box
double faces_of(const Inputs& in);         // of the box, its sides included
double liquid_cells_of(const Inputs& in);  // that have a row of the system

// For the kernels of velocity and pressure.
Scenes pressure_scenes();

}  // namespace lockstep::verify::production_fluid_inputs
