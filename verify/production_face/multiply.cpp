// Products of stiffness matrices, as the verifier and the benchmark see them: bitwise, but for that by edges, which
// adds in another order. notes/production_face.md derives its bound.
#include "common/production_face/multiply.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/linear/multiply.h"
#include "common/production_face/assemble.h"
#include "verify/inputs.h"
#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::production_face {

// The scene's stiffness matrix, laid out in each way.
struct Matrices {
  linear::BlockRows<float> rows;
  linear::SlicedBlockRows sliced;
  Edges<float> edges;
};

inline double bytes_of(const Matrices& k) {
  return 4. * double(k.rows.value.size() + k.sliced.value.size() + k.edges.between.size());
}

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_multiply {
namespace {

using namespace production_face;
using namespace production_face_inputs;

struct State {
  Array<float> y;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("y", state.y, state.y.size());
}

std::shared_ptr<const Matrices> matrices(const std::string& path) {
  return lockstep::verify::inputs<Matrices>(path, [&] {
    const auto in = inputs(path);
    const Pattern pattern = make_pattern(in->body);
    auto rows = make_block_rows<float>(pattern);
    production_face::serial::assemble(in->body, *strained(path), pattern, rows);
    return Matrices{rows, linear::slice(rows), make_edges(rows)};
  });
}

// Random numbers from -1 to 1.
std::shared_ptr<const Array<float>> vector_of(const Body<float>& body) {
  Array<float> x(3 * static_cast<std::size_t>(body.nodes));
  std::mt19937 random(1);
  for (float& e : x) e = std::uniform_real_distribution<float>(-1, 1)(random);
  return std::make_shared<const Array<float>>(std::move(x));
}

std::shared_ptr<const State> start(const Body<float>& body) {
  State state = {Array<float>(3 * static_cast<std::size_t>(body.nodes))};
  poison(state);
  return std::make_shared<const State>(std::move(state));
}

// A tetrahedron reads its corners and 40 numbers. It takes 18 products of a matrix and a vector, or of their size, and
// some more.
Case make_matrix_free(const std::string& path) {
  const auto in = inputs(path);
  const auto state = strained(path);
  const auto x = vector_of(in->body);
  const auto in_waves = std::make_shared<const Waves>(waves(in->body));
  const auto parts = poisoned_parts(in->body);
  const double n = in->body.tetrahedra;
  return make_case<State>({
      .start = start(in->body),
      .serial = [=](State& s) { serial::multiply_matrix_free(in->body, *state, *x, s.y); },
      .best_serial = nullptr,
      .openmp = [=](State& s) { openmp::multiply_matrix_free(in->body, *state, *x, *in_waves, *parts, s.y); },
      .compare = bitwise_and_poison<State>(parts),
      .work = {n, "tetrahedra", 4 * (44 * n + 6. * in->body.nodes), 290 * n, n / in->body.padded_tetrahedra()},
  });
}

// A number is a product and a sum.
Work work_of(const Matrices& k) {
  const double numbers = double(k.rows.value.size());
  return {numbers, "entries", linear::bytes_of(k.sliced) + 24. * k.rows.rows, 2 * numbers,
          double(k.rows.column.size()) / double(k.sliced.column.size())};
}

Case make_block_rows(const std::string& path) {
  const auto in = inputs(path);
  const auto k = matrices(path);
  const auto x = vector_of(in->body);
  return make_case<State>({
      .start = start(in->body),
      .serial = [=](State& s) { linear::serial::multiply(k->rows, *x, s.y); },
      .best_serial = nullptr,
      .openmp = [=](State& s) { linear::openmp::multiply(k->sliced, *x, s.y); },
      .compare = nullptr,
      .work = work_of(*k),
  });
}

// How far a product's two sums may be apart: each rounds by u for each of its terms.
std::vector<double> rounding_of(const linear::BlockRows<float>& k, const Array<float>& x) {
  std::vector<double> rounding(x.size());
  for (int i = 0; i < k.rows; ++i) {
    const int terms = 3 * (k.begin[i + 1] - k.begin[i]);
    for (int place = k.begin[i]; place < k.begin[i + 1]; ++place)
      for (int e = 0; e < 9; ++e)
        rounding[3 * i + e / 3] +=
            2 * terms * unit_roundoff *
            std::abs(double(k.value[9 * std::size_t(place) + e]) * x[3 * k.column[place] + e % 3]);
  }
  return rounding;
}

// The sliced product is compared with that by edges directly, not by way of the truth: neither is the other's twin.
Case make_edges_case(const std::string& path) {
  const auto in = inputs(path);
  const auto k = matrices(path);
  const auto x = vector_of(in->body);
  const auto rounding = std::make_shared<const std::vector<double>>(rounding_of(k->rows, *x));
  return make_case<State>({
      .start = start(in->body),
      .serial = [=](State& s) { serial::multiply_edges(k->edges, *x, s.y); },
      .best_serial = nullptr,
      .openmp = [=](State& s) { linear::openmp::multiply(k->sliced, *x, s.y); },
      .compare =
          [rounding](const State& openmp, const State& serial) {
            Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
            const std::vector<double> by_edges(serial.y.begin(), serial.y.end());
            within_bound(judgement, openmp.y, serial.y, by_edges, *rounding, [](std::size_t i) {
              return "xyz"[i % 3] + (" of node " + std::to_string(i / 3));
            });
            return judgement;
          },
      .work = work_of(*k),
  });
}

Scenes without_tsan(Scenes scenes) {
  scenes.tsan = {};
  return scenes;
}

const Register multiply{{.name = "production_face/multiply",
                         .place = 4,
                         .serial_forms = {"matrix_free", "edges"},
                         .forms = {{.name = "matrix_free", .make = make_matrix_free, .scenes = body_scenes()},
                                   {.name = "block_rows", .make = make_block_rows, .scenes = body_scenes()},
                                   {.name = "edges",
                                    .make = make_edges_case,
                                    .scenes = without_tsan(body_scenes()),
                                    .covered_by = "block_rows"}}}};

}  // namespace
}  // namespace lockstep::verify::production_face_multiply
