// Coarse levels of the face's multigrid: sixteen couplings or aggregates at a time, where their matrices are made.
//
// The algorithm stands in serial/production_face/multigrid.cpp. A coupling is a lane, which adds its shares in order;
// their blocks are gathered from the slices of the finer matrix. Coarse matrices are slices, for linear's products.
// Aggregates, and members, are shared among threads where forces are summed and corrections handed down.
//
// The contract stands in common/production_face/multigrid.h.
#include "common/production_face/multigrid.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "common/linear/multiply.h"
#include "common/linear/update.h"
#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {
namespace {

using linear::BlockRows;
using linear::SlicedBlockRows;
using Level = CoarseLevel<Real>;
using Memory = Multigrid<Real, SlicedBlockRows>;

// Where element 0 of each block is in the slices' values; blocks by rows, as in linear::BlockRows.
Array<std::int32_t> places_of(const SlicedBlockRows& sliced) {
  Array<std::int32_t> begin(sliced.rows + 1, 0);
  for (std::size_t k = 0; k < sliced.row.size(); ++k)
    if (sliced.row[k] >= 0) begin[sliced.row[k] + 1] = sliced.length[k];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  if (sliced.value.size() > std::numeric_limits<std::int32_t>::max())
    throw std::length_error("a sliced matrix of more than 2^31 numbers");
  Array<std::int32_t> at(begin.back());
  for (int slice = 0; slice < sliced.slices(); ++slice)
    for (int lane = 0; lane < lanes; ++lane)
      for (int k = 0; k < sliced.length[slice * lanes + lane]; ++k)
        at[begin[sliced.row[slice * lanes + lane]] + k] = 9 * lanes * (sliced.first_slot[slice] + k) + lane;
  return at;
}

Triple<Real> triple(const Array<Real>& array, std::size_t i) { return {{array[i], array[i + 1], array[i + 2]}}; }

// Three numbers from each lane's place on.
LOCKSTEP_INLINE Triple<floatv> triple(const Real* array, intv i, maskv in) {
  return {{gather(array, i, in), gather(array + 1, i, in), gather(array + 2, i, in)}};
}

// A = P^T K P.
template <int parts>
void couple(const Level& level, const SlicedBlockRows& k, const Array<std::int32_t>& at_k, SlicedBlockRows& a,
            const Array<std::int32_t>& at) {
  // A coupling writes its own blocks alone.
#pragma omp parallel for schedule(dynamic, 4)
  for (int first = 0; first < level.couplings(); first += lanes) {
    const maskv in = first_lanes(level.couplings() - first);
    const intv begin = load(&level.first_share[first], in);
    const intv count = load(level.first_share.data() + first + 1, in) - begin;
    MemberBlocks<floatv, 2> sum;
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q)
        for (int e = 0; e < 9; ++e) sum.part[p][q].e[e / 3][e % 3] = 0.f;
    for (int turn = 0; any(count > intv(turn)); ++turn) {
      const maskv active = count > intv(turn);
      const intv s = begin + intv(turn);
      MemberBlocks<floatv, parts> share;
      for (int p = 0; p < parts; ++p)
        for (int q = 0; q < parts; ++q) {
          const intv block = gather(level.share.data(), (s * intv(parts) + intv(p)) * intv(parts) + intv(q), active);
          const intv place = gather(at_k.data(), block, active);
          for (int e = 0; e < 9; ++e)
            share.part[p][q].e[e / 3][e % 3] = gather(k.value.data() + lanes * e, place, active);
        }
      const intv i = gather(level.i.data(), s, active), j = gather(level.j.data(), s, active);
      const auto added =
          coupled(share, triple(level.arm.data(), i * intv(3), active), triple(level.arm.data(), j * intv(3), active));
      for (int p = 0; p < 2; ++p)
        for (int q = 0; q < 2; ++q)
          for (int e = 0; e < 9; ++e) where(active, sum.part[p][q].e[e / 3][e % 3]) += added.part[p][q].e[e / 3][e % 3];
    }
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            Real of_lane[lanes];
            store(of_lane, sum.part[p][q].e[r][c]);
            for (int n = first; n < std::min(first + lanes, level.couplings()); ++n) {
              const Level::Coupling& coupling = level.coupling[n];
              a.value[at[coupling.mirrored[p][q]] + lanes * (3 * c + r)] = of_lane[n - first];
              a.value[at[coupling.place[p][q]] + lanes * (3 * r + c)] = of_lane[n - first];
            }
          }
  }
}

// S.
void set_smoother(const Level& level, const SlicedBlockRows& a, const Array<std::int32_t>& at,
                  SlicedBlockRows& smoother, const Array<std::int32_t>& at_smoother) {
  // An aggregate writes its own blocks alone.
#pragma omp parallel for schedule(static)
  for (int first = 0; first < level.count(); first += lanes) {
    const int count = std::min(lanes, level.count() - first);
    Block6<floatv> block;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        Real of_lane[lanes] = {};
        for (int lane = 0; lane < count; ++lane) {
          const Level::Coupling& own = level.coupling[level.diagonal[first + lane]];
          of_lane[lane] = a.value[at[own.place[i / 3][j / 3]] + lanes * (i % 3 * 3 + j % 3)];
        }
        block.e[i][j] = load(of_lane);
      }
    const Block6<floatv> inverted = smoother_of(block);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        Real of_lane[lanes];
        store(of_lane, inverted.e[i][j]);
        for (int lane = 0; lane < count; ++lane)
          smoother.value[at_smoother[4 * (first + lane) + i / 3 * 2 + j / 3] + lanes * (i % 3 * 3 + j % 3)] =
              of_lane[lane];
      }
  }
}

// P^T r. A member's numbers stand side by side, and members of neighbouring aggregates far from each other: lanes would
// gather each number from a line of its own.
template <int parts>
void restrict_to(const Level& level, std::span<const Real> r, std::span<Real> coarse) {
  // An aggregate writes its own numbers alone.
#pragma omp parallel for schedule(static)
  for (int n = 0; n < level.count(); ++n) {
    Real force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};
    for (int k = level.first[n]; k < level.first[n + 1]; ++k) {
      const std::size_t i = level.member[k];
      const Triple<Real> own = {{r[3 * parts * i], r[3 * parts * i + 1], r[3 * parts * i + 2]}};
      const Triple<Real> turned = crossed(triple(level.arm, 3 * i), own);
      for (int c = 0; c < 3; ++c) {
        force[c] += own.c[c], torque[c] += turned.c[c];
        if constexpr (parts == 2) torque[c] += r[6 * i + 3 + c];
      }
    }
    Real* const to = &coarse[6 * static_cast<std::size_t>(n)];
    for (int c = 0; c < 3; ++c) to[c] = force[c], to[3 + c] = torque[c];
  }
}

// z += P e.
template <int parts>
void prolong(const Level& level, std::span<const Real> coarse, std::span<Real> z) {
  // A member writes its own numbers alone.
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < level.members(); ++i) {
    if (level.of[i] < 0) continue;
    const Real* const e = &coarse[6 * static_cast<std::size_t>(level.of[i])];
    const Triple<Real> turned = crossed({{e[3], e[4], e[5]}}, triple(level.arm, 3 * i));
    for (int c = 0; c < 3; ++c) {
      z[3 * parts * i + c] += e[c] + turned.c[c];
      if constexpr (parts == 2) z[6 * i + 3 + c] += e[3 + c];
    }
  }
}

// rest = r - A z.
void set_rest(MultigridLevel<Real, SlicedBlockRows>& m) {
  linear::openmp::multiply(m.a, m.z, m.product);
  // An element is written by its own iteration alone.
#pragma omp parallel for simd schedule(static)
  for (std::size_t i = 0; i < m.r.size(); ++i) m.rest[i] = m.r[i] - m.product[i];
}

// z += S (r - A z).
void smooth(MultigridLevel<Real, SlicedBlockRows>& m) {
  set_rest(m);
  linear::openmp::multiply(m.smoother, m.rest, m.product);
  linear::openmp::axpy(Real(1), m.product, m.z);
}

// z = C r of a level.
void cycle(const Coarsening<Real>& coarsening, std::size_t l, Memory& memory) {
  auto& m = memory.level[l];
  if (l + 1 == memory.level.size() && memory.last) return solve<Real>(*memory.last, m.r, m.z);
  linear::openmp::multiply(m.smoother, m.r, m.z);
  if (l + 1 == memory.level.size()) return;
  for (int visit = 0; visit < visits; ++visit) {
    if (visit > 0) smooth(m);
    set_rest(m);
    restrict_to<2>(coarsening.level[l + 1], m.rest, memory.level[l + 1].r);
    cycle(coarsening, l + 1, memory);
    prolong<2>(coarsening.level[l + 1], memory.level[l + 1].z, m.z);
    smooth(m);
  }
}

// A of the last level, as plain rows.
BlockRows<Real> plain(const Level& level, const MultigridLevel<Real, SlicedBlockRows>& m) {
  BlockRows<Real> a = make_block_rows(level);
  for (std::size_t k = 0; k < a.column.size(); ++k)
    for (int e = 0; e < 9; ++e) a.value[9 * k + e] = m.a.value[m.at[k] + lanes * e];
  return a;
}

}  // namespace

Memory make_multigrid(const Coarsening<Real>& coarsening, const SlicedBlockRows& k) {
  Memory memory;
  memory.at = places_of(k);
  for (const Level& level : coarsening.level) {
    auto& m = memory.level.emplace_back();
    m.a = linear::slice(make_block_rows(level)), m.smoother = linear::slice(make_diagonal_rows(level));
    m.at = places_of(m.a), m.at_smoother = places_of(m.smoother);
    for (Array<Real>* vector : {&m.r, &m.z, &m.rest, &m.product})
      vector->resize(6 * static_cast<std::size_t>(level.count()));
  }
  return memory;
}

void set_coarse(const Coarsening<Real>& coarsening, const SlicedBlockRows& k, Memory& memory) {
  for (std::size_t l = 0; l < memory.level.size(); ++l) {
    auto& m = memory.level[l];
    if (l == 0)
      couple<1>(coarsening.level[l], k, memory.at, m.a, m.at);
    else
      couple<2>(coarsening.level[l], memory.level[l - 1].a, memory.level[l - 1].at, m.a, m.at);
    set_smoother(coarsening.level[l], m.a, m.at, m.smoother, m.at_smoother);
  }
  if (!memory.level.empty()) memory.last = factor(plain(coarsening.level.back(), memory.level.back()));
}

void correct(const Coarsening<Real>& coarsening, std::span<const Real> r, std::span<Real> z, Memory& memory) {
  if (memory.level.empty()) return;
  restrict_to<1>(coarsening.level[0], r, memory.level[0].r);
  cycle(coarsening, 0, memory);
  prolong<1>(coarsening.level[0], memory.level[0].z, z);
}

}  // namespace lockstep::production_face::openmp
