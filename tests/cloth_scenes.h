// A test that writes a scene of cloth and loads it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/cloth/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep::cloth {

struct ClothSceneTest : TemporaryFolder {
  static inline const std::string head = "kind = \"cloth\"\n";
  static inline const std::string sheet =
      "[sheet]\nrows = 3\ncolumns = 5\norigin = [1, 2, 3]\nwidth = [4, 0, 0]\nheight = [0, -1, 0]\nmass = 0.3\n";
  static inline const std::string mesh = "[mesh]\nfile = \"a.obj\"\nmass = 0.3\n";
  // Points 1 2 3 4 of a unit square, around it.
  static inline const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return load_scene(path("a.toml"));
  }
  // The message without the folder: "a.toml:line:column: ...".
  std::string error(const std::string& toml) const {
    return without_folder(error_of([&] { load(toml); }));
  }

  std::string without_folder(const std::string& message) const {
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(message.size(), folder.size() + 1));
  }
};

}  // namespace lockstep::cloth
