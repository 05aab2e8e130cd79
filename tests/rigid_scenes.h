// A test that writes a scene of rigid bodies and loads it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/rigid/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep::rigid::worlds {

struct RigidSceneTest : TemporaryFolder {
  static inline const std::string head = "kind = \"rigid\"\nframes = 9\n";
  static inline const std::string ball = "[[body]]\nsphere = 0.5\nmass = 2\n";

  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return load_scene(path("a.toml"));
  }
  // The message without the folder: "a.toml:line:column: ...".
  std::string error(const std::string& toml) const {
    const std::string message = error_of([&] { load(toml); });
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(message.size(), folder.size() + 1));
  }
};

}  // namespace lockstep::rigid::worlds
