// Sparse products, as the verifier and the benchmark see them: bitwise. Speeds of a product by block rows are relative
// to the serial product of the same matrix by rows of numbers.
#include "common/linear/multiply.h"

#include "verify/linear/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::linear_multiply {
namespace {

using namespace linear;
using namespace linear_inputs;

std::shared_ptr<const State> start(const Inputs& in) {
  return std::make_shared<const State>(State{{}, Array<float>(in.scene.rows.rows, unwritten), {}});
}

// An entry is a product and a sum. What is read is the matrix as openmp holds it, once, and x; y is written.
Work work_of(const Inputs& in, double matrix_bytes, double lane_use) {
  const double entries = double(in.scene.rows.value.size());
  return {entries, "entries", matrix_bytes + 4. * in.scene.rows.rows + 4. * in.scene.rows.columns, 2 * entries,
          lane_use};
}

Case make_rows(const std::string& path) {
  const auto in = inputs(path);
  const double places = double(in->sliced.slots.size()) * lanes;
  return make_case<State>({
      .start = start(*in),
      .serial = [in](State& s) { serial::multiply(in->scene.rows, in->x, s.y); },
      .best_serial = nullptr,
      .openmp = [in](State& s) { openmp::multiply(in->sliced, in->x, s.y); },
      .compare = nullptr,
      .work = work_of(*in, bytes_of(in->sliced), double(in->scene.rows.value.size()) / places),
  });
}

Case make_rows_and_dot(const std::string& path) {
  const auto in = inputs(path);
  State first = *start(*in);
  first.number = {unwritten};
  const double places = double(in->sliced.slots.size()) * lanes;
  return make_case<State>({
      .start = std::make_shared<const State>(first),
      .serial = [in](State& s) { s.number[0] = serial::multiply_and_dot(in->scene.rows, in->x, s.y); },
      .best_serial = nullptr,
      .openmp = [in](State& s) { s.number[0] = openmp::multiply_and_dot(in->sliced, in->x, s.y); },
      .compare = nullptr,
      .work = work_of(*in, bytes_of(in->sliced), double(in->scene.rows.value.size()) / places),
  });
}

Case make_block_rows(const std::string& path) {
  const auto in = inputs(path);
  return make_case<State>({
      .start = start(*in),
      .serial = [in](State& s) { serial::multiply(in->scene.blocks, in->x, s.y); },
      .best_serial = [in](State& s) { serial::multiply(in->scene.rows, in->x, s.y); },
      .openmp = [in](State& s) { openmp::multiply(in->sliced_blocks, in->x, s.y); },
      .compare = nullptr,
      .work = work_of(*in, bytes_of(in->sliced_blocks),
                      double(in->scene.blocks.column.size()) / double(in->sliced_blocks.column.size())),
  });
}

// Each of a block's nine entries is a product and a difference, in double; b is read besides, and x has eight bytes an
// element.
Case make_residual(const std::string& path) {
  const auto in = inputs(path);
  Work work = work_of(*in, bytes_of(in->sliced_blocks),
                      double(in->scene.blocks.column.size()) / double(in->sliced_blocks.column.size()));
  work.bytes += 8. * in->scene.rows.rows;
  const auto x = std::make_shared<const Array<double>>(lockstep::convert<double>(in->x));
  return make_case<State>({
      .start = start(*in),
      .serial = [in, x](State& s) { serial::residual(in->scene.blocks, in->scene.b, *x, s.y); },
      .best_serial = nullptr,
      .openmp = [in, x](State& s) { openmp::residual(in->sliced_blocks, in->scene.b, *x, s.y); },
      .compare = nullptr,
      .work = work,
  });
}

bool is_solvable_in_blocks(const std::string& path) { return is_solvable(path) && has_blocks(path); }

const Scenes for_rows = {.verify = {"poisson_64", "poisson_32", "file_truss", "file_general", "elasticity_24"},
                         .more = {"poisson_128", "elasticity_48"},
                         .bench = {"poisson_128"},
                         .tsan = {"poisson_32", "file_general"}};
const Scenes for_rows_and_dot = {.verify = {"poisson_64", "poisson_32", "file_truss", "elasticity_24"},
                                 .more = {"poisson_128", "elasticity_48"},
                                 .bench = {"poisson_128"},
                                 .tsan = {"poisson_32"}};
const Scenes for_block_rows = {
    .verify = {"elasticity_24"}, .more = {"elasticity_48"}, .bench = {"elasticity_48"}, .tsan = {"elasticity_24"}};

const Register multiply{
    {.name = "linear/multiply",
     .place = 3,
     .serial_forms = {"rows", "rows_and_dot", "block_rows", "residual"},
     .forms = {{.name = "rows", .make = make_rows, .scenes = for_rows},
               {.name = "rows_and_dot", .make = make_rows_and_dot, .scenes = for_rows_and_dot, .takes = is_solvable},
               {.name = "block_rows", .make = make_block_rows, .scenes = for_block_rows, .takes = has_blocks},
               {.name = "residual", .make = make_residual, .scenes = for_block_rows, .takes = is_solvable_in_blocks}}}};

}  // namespace
}  // namespace lockstep::verify::linear_multiply
