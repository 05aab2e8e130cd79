// Names on the command line: kernels, forms and scenes, and the nearest ones to a name that is unknown.
#pragma once

#include <string>
#include <vector>

namespace lockstep::verify {

// Whether `named` names the kernel: the whole name (fluid/forces), its domain (fluid), its last part (forces), or a
// pattern with * and ?.
bool names_kernel(const std::string& named, const std::string& kernel);

// The words with `between` between them.
std::string joined(const std::vector<std::string>& words, const std::string& between);

// "; did you mean a, b?" with the candidates nearest to a word, by insertions, deletions and replacements of letters.
// Letters at a candidate's end are free, so that dambreak is near dam_break_5k. "" if no candidate is near.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

// The folder of the project's scenes: scenes/ in the working directory, or else beside the program's build/.
std::string scenes_folder();

// The file of a scene, named by a path or, for the project's own, by its name (flag_33). Throws InputError if there is
// none.
std::string scene_file(const std::string& named);

}  // namespace lockstep::verify
