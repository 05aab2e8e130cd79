// Coarse levels of the face's multigrid.
//
// Jacobi's method removes errors that change from node to node. It passes a push on by one node an iteration, so smooth
// errors take as many iterations as there are nodes across the face. Smooth errors are nearly rigid motions of
// neighbouring nodes. So they are solved for as rigid motions of aggregates of nodes. Their matrix is P^T K P, with a
// twentieth of the rows. It is solved in the same way, by larger aggregates.
//
// Jacobi's method removes what rigid motions do not explain, before and after, on each level. Coarse levels are small,
// so each is gone through twice.
//
// The contract stands in common/production_face/multigrid.h.
#include "common/production_face/multigrid.h"

#include <algorithm>

#include "common/linear/multiply.h"
#include "common/linear/update.h"
#include "common/real.h"

namespace lockstep::production_face::serial {
namespace {

using linear::BlockRows;
using Level = CoarseLevel<Real>;
using Memory = Multigrid<Real, BlockRows<Real>>;

Triple<Real> triple(const Array<Real>& array, std::size_t i) { return {{array[i], array[i + 1], array[i + 2]}}; }

// A = P^T K P.
template <int parts>
void couple(const Level& level, const BlockRows<Real>& k, BlockRows<Real>& a) {
  for (int n = 0; n < level.couplings(); ++n) {
    MemberBlocks<Real, 2> sum = {};
    for (int s = level.first_share[n]; s < level.first_share[n + 1]; ++s) {
      MemberBlocks<Real, parts> share;
      for (int p = 0; p < parts; ++p)
        for (int q = 0; q < parts; ++q) {
          const std::size_t block = level.share[(static_cast<std::size_t>(s) * parts + p) * parts + q];
          for (int e = 0; e < 9; ++e) share.part[p][q].e[e / 3][e % 3] = k.value[9 * block + e];
        }
      const auto added = coupled(share, triple(level.arm, 3 * level.i[s]), triple(level.arm, 3 * level.j[s]));
      for (int p = 0; p < 2; ++p)
        for (int q = 0; q < 2; ++q)
          for (int e = 0; e < 9; ++e) sum.part[p][q].e[e / 3][e % 3] += added.part[p][q].e[e / 3][e % 3];
    }
    const Level::Coupling& coupling = level.coupling[n];
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            a.value[9 * static_cast<std::size_t>(coupling.mirrored[p][q]) + 3 * c + r] = sum.part[p][q].e[r][c];
            a.value[9 * static_cast<std::size_t>(coupling.place[p][q]) + 3 * r + c] = sum.part[p][q].e[r][c];
          }
  }
}

// S.
void set_smoother(const Level& level, const BlockRows<Real>& a, BlockRows<Real>& smoother) {
  for (int n = 0; n < level.count(); ++n) {
    const Level::Coupling& own = level.coupling[level.diagonal[n]];
    Block6<Real> block;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        block.e[i][j] = a.value[9 * static_cast<std::size_t>(own.place[i / 3][j / 3]) + i % 3 * 3 + j % 3];
    const Block6<Real> inverted = smoother_of(block);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        smoother.value[9 * (4 * static_cast<std::size_t>(n) + i / 3 * 2 + j / 3) + i % 3 * 3 + j % 3] =
            inverted.e[i][j];
  }
}

// P^T r.
template <int parts>
void restrict_to(const Level& level, std::span<const Real> r, std::span<Real> coarse) {
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
    for (int c = 0; c < 3; ++c)
      coarse[6 * static_cast<std::size_t>(n) + c] = force[c],
                                               coarse[6 * static_cast<std::size_t>(n) + 3 + c] = torque[c];
  }
}

// z += P e.
template <int parts>
void prolong(const Level& level, std::span<const Real> coarse, std::span<Real> z) {
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
void set_rest(MultigridLevel<Real, BlockRows<Real>>& m) {
  linear::serial::multiply(m.a, m.z, m.product);
  for (std::size_t i = 0; i < m.r.size(); ++i) m.rest[i] = m.r[i] - m.product[i];
}

// z += S (r - A z).
void smooth(MultigridLevel<Real, BlockRows<Real>>& m) {
  set_rest(m);
  linear::serial::multiply(m.smoother, m.rest, m.product);
  linear::serial::axpy(Real(1), m.product, m.z);
}

// z = C r of a level.
void cycle(const Coarsening<Real>& coarsening, std::size_t l, Memory& memory) {
  auto& m = memory.level[l];
  if (l + 1 == memory.level.size() && memory.last) return solve<Real>(*memory.last, m.r, m.z);
  linear::serial::multiply(m.smoother, m.r, m.z);
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

}  // namespace

Memory make_multigrid(const Coarsening<Real>& coarsening, const BlockRows<Real>&) {
  Memory memory;
  for (const Level& level : coarsening.level) {
    auto& m = memory.level.emplace_back();
    m.a = make_block_rows(level), m.smoother = make_diagonal_rows(level);
    for (Array<Real>* vector : {&m.r, &m.z, &m.rest, &m.product})
      vector->resize(6 * static_cast<std::size_t>(level.count()));
  }
  return memory;
}

void set_coarse(const Coarsening<Real>& coarsening, const BlockRows<Real>& k, Memory& memory) {
  for (std::size_t l = 0; l < memory.level.size(); ++l) {
    auto& m = memory.level[l];
    if (l == 0)
      couple<1>(coarsening.level[l], k, m.a);
    else
      couple<2>(coarsening.level[l], memory.level[l - 1].a, m.a);
    set_smoother(coarsening.level[l], m.a, m.smoother);
  }
  if (!memory.level.empty()) memory.last = factor(memory.level.back().a);
}

void correct(const Coarsening<Real>& coarsening, std::span<const Real> r, std::span<Real> z, Memory& memory) {
  if (memory.level.empty()) return;
  restrict_to<1>(coarsening.level[0], r, memory.level[0].r);
  cycle(coarsening, 0, memory);
  prolong<1>(coarsening.level[0], memory.level[0].z, z);
}

}  // namespace lockstep::production_face::serial
