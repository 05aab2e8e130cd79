// Solid bodies as scenes of cloth describe them. scenes/README.md has the keys.
//
// Each reads the keys of one kind of body from its table, and leaves others alone: the caller has checked which keys
// there may be. Throws InputError where a value is not what scenes/README.md says.
#pragma once

#include "common/cloth/cloth.h"
#include "common/toml.h"

namespace lockstep::cloth {

Plane<double> plane_of(const toml::table& table);      // normal, point
Capsule<double> sphere_of(const toml::table& table);   // centre, radius
Capsule<double> capsule_of(const toml::table& table);  // from, to, radius
Box<double> box_of(const toml::table& table);          // centre, half, turn

}  // namespace lockstep::cloth
