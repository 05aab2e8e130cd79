// Vector updates, as the verifier and the benchmark see them: bitwise.
#include "common/linear/update.h"

#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::linear_update {
namespace {

using namespace linear;
using namespace linear_inputs;

// The vectors that change are b and x; the one that is only read is b reversed.
struct Read {
  std::shared_ptr<const State> start;
  Array<float> p;
};

std::shared_ptr<const Read> read(const std::string& path) {
  const auto in = inputs(path);
  const std::size_t n = std::min(in->scene.b.size(), in->x.size());
  const State start{{in->scene.b.begin(), in->scene.b.begin() + n}, {in->x.begin(), in->x.begin() + n}, {unwritten}};
  return std::make_shared<const Read>(Read{std::make_shared<const State>(start), {start.x.rbegin(), start.x.rend()}});
}

using Update = std::function<void(State&)>;

// Of an element: floats that are read or written; floats that there are; flops.
struct Cost {
  double moved, held, flops;
};

Case make(const std::shared_ptr<const Read>& in, const Update& serial, const Update& openmp, const Cost& cost) {
  const double n = double(in->p.size());
  return make_case<State>({.start = in->start,
                           .serial = serial,
                           .best_serial = nullptr,
                           .openmp = openmp,
                           .compare = nullptr,
                           .work = {.items = n,
                                    .unit = "elements",
                                    .bytes = sizeof(float) * cost.moved * n,
                                    .flops = cost.flops * n,
                                    .data = sizeof(float) * cost.held * n}});
}

Case make_axpy(const std::string& path) {
  const auto in = read(path);
  return make(
      in, [in](State& s) { serial::axpy(.7f, in->p, s.y); }, [in](State& s) { openmp::axpy(.7f, in->p, s.y); },
      {.moved = 3, .held = 2, .flops = 2});
}

Case make_advance(const std::string& path) {
  const auto in = read(path);
  const auto with = [in](Advance<float>* advance) {
    return [in, advance](State& s) { advance(.7f, in->p, .3f, s.x, s.y); };
  };
  return make(in, with(serial::advance), with(openmp::advance), {.moved = 5, .held = 3, .flops = 4});
}

Case make_descend(const std::string& path) {
  const auto in = read(path);
  const auto with = [in](Descend<float>* descend) {
    return [in, descend](State& s) { s.number[0] = descend(.7f, in->p, s.y); };
  };
  return make(in, with(serial::descend), with(openmp::descend), {.moved = 3, .held = 2, .flops = 4});
}

const Scenes scenes = {.verify = {"poisson_64", "file_truss", "file_general"},
                       .more = {"poisson_128"},
                       .bench = {"poisson_128"},
                       .tsan = {"poisson_32"}};

const Register update{{.name = "linear/update",
                       .place = 2,
                       .serial_forms = {"axpy", "advance", "descend"},
                       .forms = {{.name = "axpy", .make = make_axpy, .scenes = scenes},
                                 {.name = "advance", .make = make_advance, .scenes = scenes},
                                 {.name = "descend", .make = make_descend, .scenes = scenes}}}};

}  // namespace
}  // namespace lockstep::verify::linear_update
