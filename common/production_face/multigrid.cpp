#include "common/production_face/multigrid.h"

// All files of common/ that include Eigen define this: what Eigen inlines and how it allocates depends on it, and must
// not differ between files.
#define EIGEN_DONT_VECTORIZE
#include <eigen3/Eigen/Sparse>

namespace lockstep::production_face {

class CoarseFactor {
 public:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;
};

template <class Real>
std::shared_ptr<const CoarseFactor> factor(const linear::BlockRows<Real>& a) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < a.rows; ++row)
    for (int k = a.begin[row]; k < a.begin[row + 1]; ++k)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int i = 3 * row + r, j = 3 * a.column[k] + c;
          const double value = a.value[9 * static_cast<std::size_t>(k) + 3 * r + c];
          if (i >= j) entries.emplace_back(i, j, i == j && value == 0 ? 1 : value);
        }
  Eigen::SparseMatrix<double> matrix(3 * a.rows, 3 * a.rows);
  matrix.setFromTriplets(entries.begin(), entries.end());
  auto result = std::make_shared<CoarseFactor>();
  result->factor.compute(matrix);
  if (result->factor.info() != Eigen::Success) return nullptr;
  // Definite where every pivot is greater than rounding could make of 0, with room to spare.
  const Eigen::VectorXd size = result->factor.permutationP() * Eigen::VectorXd(matrix.diagonal().cwiseAbs());
  const bool is_definite = (result->factor.vectorD().array() > 1e-6 * size.array()).all();
  return is_definite ? result : nullptr;
}

template <class Real>
void solve(const CoarseFactor& factor, std::span<const Real> r, std::span<Real> z) {
  using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
  const Eigen::VectorXd right = Eigen::Map<const Vector>(r.data(), r.size()).template cast<double>();
  const Eigen::VectorXd solution = factor.factor.solve(right);
  Eigen::Map<Vector>(z.data(), z.size()) = solution.template cast<Real>();
}

template std::shared_ptr<const CoarseFactor> factor(const linear::BlockRows<float>& a);
template std::shared_ptr<const CoarseFactor> factor(const linear::BlockRows<double>& a);
template void solve(const CoarseFactor& factor, std::span<const float> r, std::span<float> z);
template void solve(const CoarseFactor& factor, std::span<const double> r, std::span<double> z);

}  // namespace lockstep::production_face
