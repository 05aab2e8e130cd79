// Contacts of a folded cloth, for the kernels that answer them.
#pragma once

#include "common/production_cloth/repulsions.h"
#include "verify/kernel.h"
#include "verify/production_cloth/inputs.h"

namespace lockstep::production_cloth {

// The scene's cloth, folded in four layers that are six tenths of the thickness apart, shaken, and drawn together about
// a point, where vertices have many contacts. Layers approach each other.
struct ContactInputs {
  std::shared_ptr<const Scene> scene;
  float time_step;  // s
  Array<float> inverse_mass;
  Vectors<float> position, velocity;
  ElementPairs pairs;      // whose boxes come within the thickness
  ElementPairs excluded;   // every seventh
  Contacts<float> nearby;  // of the pairs
};

double bytes_of(const ContactInputs& inputs);

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_inputs {

std::shared_ptr<const production_cloth::ContactInputs> contact_inputs(const std::string& path);

// m^2/s^2: the sum over contacts of the square of the speed at which they approach.
double approach_of(const production_cloth::Contacts<float>& contacts, const Vectors<float>& velocity);

// The share of lanes that hold a contact, where they come in batches.
double lane_use_of_batches(const production_cloth::ContactInputs& inputs);

// A contact reads 12 numbers of its own, and reads and writes velocities and masses of four vertices; it takes about
// 150 operations.
Work work_of_contacts(const production_cloth::ContactInputs& inputs, double lane_use);

}  // namespace lockstep::verify::production_cloth_inputs
