#include "verify/frames.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <regex>
#include <vector>

#include "common/input_error.h"
#include "common/vtk.h"
#include "verify/program.h"
#include "verify/run_state.h"

namespace lockstep::verify {
namespace {

namespace fs = std::filesystem;

// What any simulation writes, or left half written. The first group holds the number of a frame.
const std::regex written(
    "(?:(?:frame|bodies|particles|spray|obstacles)_([0-9]{5,9})\\.vt[ki]|"
    "(?:frame|bodies|particles|spray|obstacles)\\.vt[ki]\\.series|"
    "(?:static|ground|obstacles|box)\\.vt[ki]|state\\.lockstep)(?:\\.tmp~)?");

struct Found {
  fs::path path;
  int frame;  // -1 of a file that belongs to no frame
};

std::vector<Found> files_of_runs(const std::string& folder) {
  std::vector<Found> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    std::smatch match;
    if (std::regex_match(name, match, written))
      found.push_back({entry.path(), match[1].matched ? std::stoi(match[1].str()) : -1});
  }
  return found;
}

void remove_file(const fs::path& path) {
  std::error_code error;
  if (!fs::remove(path, error)) throw InputError(path.string() + ": cannot be removed: " + error.message());
}

std::string name_of(const Part& part, int frame) {
  char number[16];
  std::snprintf(number, sizeof number, "_%05d", frame);
  return part.name + number + part.extension;
}

}  // namespace

Frames::Frames(const std::string& folder, const Simulation& simulation, bool resume)
    : folder_(folder), simulation_(simulation) {
  std::error_code error;
  if (!resume) fs::create_directories(folder, error);
  if (error) throw InputError(folder + ": cannot be made: " + error.message());
  opened_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (opened_ < 0) throw InputError(folder + ": cannot be opened: " + std::strerror(errno));
  // The kernel releases the lock however the process ends. A file system without locks keeps nobody out.
  if (flock(opened_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(opened_);
    throw InputError(folder + ": another run is writing its frames there");
  }
}

Frames::~Frames() { close(opened_); }

std::string Frames::state_file() const { return folder_ + "/state.lockstep"; }

void Frames::make_room(bool replace) const {
  const std::vector<Found> files = files_of_runs(folder_);
  if (!files.empty() && !replace) {
    const std::string who = run_of_state(state_file());
    throw InputError(folder_ + ": holds the frames of " + (who.empty() ? "another run" : who) +
                     "; --force replaces them" + (who.empty() ? "" : ", --resume goes on with them"));
  }
  for (const Found& file : files) remove_file(file.path);
}

void Frames::write_fixed() const {
  for (const Part& part : simulation_.parts)
    if (!part.moves) part.write(folder_ + '/' + part.name + part.extension);
}

void Frames::forget_after(int frame) const {
  for (const Found& file : files_of_runs(folder_))
    if (file.frame > frame) remove_file(file.path);
}

void Frames::write(int frame) {
  for (const Part& part : simulation_.parts)
    if (part.moves) part.write(folder_ + '/' + name_of(part, frame));
  if (now() - written_ >= 1) write_series(frame);
}

void Frames::write_series(int frame) {
  if (simulation_.time_step == 0) return;
  for (const Part& part : simulation_.parts) {
    if (!part.moves) continue;
    std::vector<vtk::Moment> moments;
    for (int k = 0; k <= frame; ++k) moments.push_back({name_of(part, k), k * simulation_.time_step});
    vtk::write_series(folder_ + '/' + part.name + part.extension + ".series", moments);
  }
  written_ = now();
}

}  // namespace lockstep::verify
