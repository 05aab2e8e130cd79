#include "common/linear/conjugate_gradients.h"

#include <cmath>

namespace lockstep::linear {

template <class Real>
Rows<Real> inverse_diagonal(const Rows<Real>& a) {
  Rows<Real> d;
  d.rows = d.columns = a.rows;
  for (int i = 0; i < a.rows; ++i) {
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
      if (a.column[k] == i) d.column.push_back(i), d.value.push_back(1 / a.value[k]);
    d.begin.push_back(static_cast<std::int32_t>(d.column.size()));
  }
  return d;
}

template <class Real>
BlockRows<Real> inverse_diagonal(const BlockRows<Real>& a) {
  BlockRows<Real> d;
  d.rows = d.columns = a.rows;
  for (int i = 0; i < a.rows; ++i) {
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      if (a.column[k] != i) continue;
      // Entry (r, c) of the adjugate is the cofactor of (c, r), from the next two rows and columns, modulo 3.
      const Real* const block = &a.value[9 * static_cast<std::size_t>(k)];
      const auto at = [&](int r, int c) { return static_cast<double>(block[3 * (r % 3) + c % 3]); };
      const auto cofactor = [&](int r, int c) {
        return at(r + 1, c + 1) * at(r + 2, c + 2) - at(r + 1, c + 2) * at(r + 2, c + 1);
      };
      const double determinant = at(0, 0) * cofactor(0, 0) + at(0, 1) * cofactor(0, 1) + at(0, 2) * cofactor(0, 2);
      d.column.push_back(i);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) d.value.push_back(static_cast<Real>(cofactor(c, r) / determinant));
    }
    d.begin.push_back(static_cast<std::int32_t>(d.column.size()));
  }
  return d;
}

template <class Real>
double residual_norm(const Rows<Real>& a, std::span<const Real> b, std::span<const Real> x) {
  double squares = 0;
  for (int i = 0; i < a.rows; ++i) {
    double rest = b[i];
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) rest -= static_cast<double>(a.value[k]) * x[a.column[k]];
    squares += rest * rest;
  }
  return std::sqrt(squares);
}

template <class Real>
double residual_norm(const BlockRows<Real>& a, std::span<const Real> b, std::span<const Real> x) {
  double squares = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.rows); ++i)
    for (int r = 0; r < 3; ++r) {
      double rest = b[3 * i + r];
      for (std::size_t k = a.begin[i]; k < static_cast<std::size_t>(a.begin[i + 1]); ++k)
        for (int c = 0; c < 3; ++c)
          rest -= static_cast<double>(a.value[9 * k + 3 * r + c]) * x[3 * static_cast<std::size_t>(a.column[k]) + c];
      squares += rest * rest;
    }
  return std::sqrt(squares);
}

template Rows<float> inverse_diagonal(const Rows<float>&);
template Rows<double> inverse_diagonal(const Rows<double>&);
template BlockRows<float> inverse_diagonal(const BlockRows<float>&);
template BlockRows<double> inverse_diagonal(const BlockRows<double>&);
template double residual_norm(const Rows<float>&, std::span<const float>, std::span<const float>);
template double residual_norm(const Rows<double>&, std::span<const double>, std::span<const double>);
template double residual_norm(const BlockRows<float>&, std::span<const float>, std::span<const float>);
template double residual_norm(const BlockRows<double>&, std::span<const double>, std::span<const double>);

}  // namespace lockstep::linear
