// One row of the incomplete Cholesky factorisation (common/linear/incomplete_cholesky.h), which serial/ does in order
// and openmp/ level by level.
#pragma once

#include "common/linear/incomplete_cholesky.h"

namespace lockstep::linear {

// A factor with the pattern of a; its values are to be filled in.
template <class Real>
Factor<Real> make_factor(const Rows<Real>& a) {
  Factor<Real> f;
  for (Rows<Real>* half : {&f.lower, &f.upper}) {
    half->rows = a.rows, half->columns = a.columns;
    half->begin.reserve(a.begin.size());
    half->column.reserve(a.column.size() / 2);
  }
  for (int i = 0; i < a.rows; ++i) {
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
      if (a.column[k] != i) (a.column[k] < i ? f.lower : f.upper).column.push_back(a.column[k]);
    for (Rows<Real>* half : {&f.lower, &f.upper}) half->begin.push_back(static_cast<std::int32_t>(half->column.size()));
  }
  f.lower.value.resize(f.lower.column.size());
  f.upper.value.resize(f.upper.column.size());
  f.inverse.resize(a.rows);
  return f;
}

// Computes row i of the lower factor, 1 / e_i, and row i of the upper factor; writes nothing else. Reads the upper rows
// and inverses of the rows j < i in whose columns row i of A has entries.
template <class Real>
void eliminate(const Rows<Real>& a, Modification modification, int i, Factor<Real>& f) {
  Rows<Real>&lower = f.lower, &upper = f.upper;
  const int lower_count = lower.begin[i + 1] - lower.begin[i];
  const int diagonal = a.begin[i] + lower_count, own = upper.begin[i];
  for (int k = diagonal + 1; k < a.begin[i + 1]; ++k) upper.value[own + k - diagonal - 1] = a.value[k];

  const Real tau = static_cast<Real>(modification.tau), sigma = static_cast<Real>(modification.sigma);
  Real e = a.value[diagonal];
  for (int k = a.begin[i]; k < diagonal; ++k) {
    const int j = a.column[k];
    int to_i = upper.begin[j];
    while (upper.column[to_i] != i) ++to_i;
    const Real l = upper.value[to_i], scaled = l * f.inverse[j];
    // Column j of L against row i of A: both ascend.
    Real dropped = 0;
    int beside = a.begin[i];
    for (int m = upper.begin[j]; m < upper.begin[j + 1]; ++m) {
      const int column = upper.column[m];
      while (beside < a.begin[i + 1] && a.column[beside] < column) ++beside;
      if (beside == a.begin[i + 1] || a.column[beside] != column)
        dropped += upper.value[m];
      else if (column > i)
        upper.value[own + beside - diagonal - 1] -= scaled * upper.value[m];
    }
    e -= scaled * (l + tau * dropped);
    lower.value[lower.begin[i] + k - a.begin[i]] = l;
  }
  f.inverse[i] = 1 / (e < sigma * a.value[diagonal] ? a.value[diagonal] : e);
}

}  // namespace lockstep::linear
