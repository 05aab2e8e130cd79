// What a pose makes of each tetrahedron.
//
// The algorithm and its serial form stand in serial/production_face/update_state.cpp. Sixteen tetrahedra, a block, at
// once; threads share the blocks. Few derivatives must be made definite, but most blocks have one such: those wait
// until there are sixteen.
//
// The contract stands in common/production_face/update_state.h.
#include "common/production_face/update_state.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {
namespace {

Vector3<floatv> load_vector(const Blocked<Real>& from, int block, int field) {
  return {load(from.vector(block, field)), load(from.vector(block, field + 1)), load(from.vector(block, field + 2))};
}

Matrix3<floatv> deformation_of(const Body<Real>& body, const Pose<Real>& pose, int block) {
  const auto& [x, y, z] = pose.displacement;
  Vector3<floatv> u[4], gradient[3];
  for (int a = 0; a < 4; ++a) {
    const intv node = load(body.corner.vector(block, a));
    u[a] = {gather(x.data(), node), gather(y.data(), node), gather(z.data(), node)};
  }
  for (int a = 0; a < 3; ++a) gradient[a] = load_vector(body.gradient, block, 3 * a);
  return deformation(u, gradient);
}

void store(Blocked<Real>& to, int block, const Matrix3<floatv>& m) {
  const floatv values[] = {m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z};
  for (int k = 0; k < 9; ++k) lockstep::store(to.vector(block, k), values[k]);
}

void store(Blocked<Real>& to, int block, const StressDerivative<floatv>& d) {
  const floatv values[] = {d.xx,      d.yy,      d.zz,      d.xy,     d.yz,     d.zx,
                           d.alpha.x, d.alpha.y, d.alpha.z, d.beta.x, d.beta.y, d.beta.z};
  for (int k = 0; k < 12; ++k) lockstep::store(to.vector(block, k), values[k]);
}

// Derivatives that must be made definite, and their tetrahedra. They wait until there are sixteen.
class Waiting {
 public:
  explicit Waiting(Strained<Real>& strained) : strained_(strained) {}

  void make_definite(int block, const StressDerivative<floatv>& d) {
    const ScaledBlock<floatv> scaled = scaled_block(d);
    const maskv waits = !is_definite(scaled);
    if (none(waits)) return;
    const auto& [xx, yy, zz, xy, zx, yz] = scaled.block;
    const floatv numbers[] = {xx, yy, zz, xy, zx, yz, scaled.size};
    for (int k = 0; k < 7; ++k) lockstep::store(number_[k] + count_, compress(waits, numbers[k]));
    lockstep::store(tetrahedron_ + count_, compress(waits, lane_index() + intv(block * lanes)));
    count_ += count(waits);
    if (count_ < lanes) return;
    finish();
    for (float(&numbers)[2 * lanes] : number_) lockstep::store(numbers, load(numbers + lanes));
    lockstep::store(tetrahedron_, load(tetrahedron_ + lanes));
    count_ -= lanes;
  }

  // Those that wait, sixteen at most.
  void finish() const {
    const auto number = [&](int k) { return load(number_[k]); };
    const auto [xx, yy, zz, xy, zx, yz] =
        definite_block<floatv>({{number(0), number(1), number(2), number(3), number(4), number(5)}, number(6)});
    const floatv values[] = {xx, yy, zz, xy, yz, zx};
    for (int k = 0; k < 6; ++k) {
      float of_lane[lanes];
      lockstep::store(of_lane, values[k]);
      for (int l = 0; l < std::min(count_, lanes); ++l) strained_.derivative.at(tetrahedron_[l], k) = of_lane[l];
    }
  }

 private:
  Strained<Real>& strained_;
  int count_ = 0;
  float number_[7][2 * lanes] = {};
  std::int32_t tetrahedron_[2 * lanes] = {};
};

// Adds what the fibres of a block pull.
void add_fibres(const Body<Real>& body, const Pose<Real>& pose, const Matrix3<floatv>& f, const maskv& definite,
                int block, Element<floatv>& e, Strained<Real>& strained) {
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const intv muscle = load(body.muscle.vector(slot, 0));
    const maskv is_there = muscle >= 0;
    const Vector3<floatv> w = load_vector(body.fibre, slot, 0);
    const floatv activation =
        gather(pose.activation.data(), muscle, is_there) * load(body.fibre.vector(slot, 3), is_there);
    const Pull<floatv> pull = add_pull(f, w, activation, load(body.fibre.vector(slot, 4)), definite, e);
    const floatv values[] = {pull.along.x, pull.along.y, pull.along.z, pull.per_stretch, pull.stiffness};
    for (int k = 0; k < 5; ++k) lockstep::store(strained.pull.vector(slot, k), values[k]);
  }
}

}  // namespace

void update_state(const Body<Real>& body, const Flesh& flesh, const Pose<Real>& pose, bool definite,
                  Strained<Real>& strained) {
  const maskv all_definite = first_lanes(definite ? lanes : 0);
  // A block writes its own tetrahedra and fibres, and reads nodes that nobody writes. What waits is of the thread's own
  // blocks.
#pragma omp parallel
  {
    Waiting waiting(strained);
#pragma omp for schedule(static)
    for (int block = 0; block < body.blocks(); ++block) {
      const Matrix3<floatv> f = deformation_of(body, pose, block);
      Element<floatv> e = element(f, flesh);
      if (definite) make_pairs_definite(e.derivative);
      add_fibres(body, pose, f, all_definite, block, e, strained);
      store(strained.stress, block, e.stress);
      store(strained.u, block, e.strain.u), store(strained.v, block, e.strain.v);
      store(strained.derivative, block, e.derivative);
      lockstep::store(strained.energy.vector(block, 0), e.energy);
      if (definite) waiting.make_definite(block, e.derivative);
    }
    waiting.finish();
  }
}

}  // namespace lockstep::production_face::openmp
