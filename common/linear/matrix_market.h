// Sparse matrices in Matrix Market files, as collections of test matrices offer them.
#pragma once

#include <string>

#include "common/linear/matrix.h"

namespace lockstep::linear {

struct MarketMatrix {
  Rows<float> rows;
  bool symmetric;  // as the file says; both triangles are in `rows`
};

// Reads `%%MatrixMarket matrix coordinate real general`; `integer` in place of `real`, and `symmetric`, which lists the
// lower triangle alone, in place of `general`. Entries come in any order; values are rounded to float. Throws
// InputError, `file:line: what was expected`, where the file is anything else: another kind of matrix, a number out of
// range or beyond float, an entry outside the matrix, above the diagonal of a symmetric one, or there twice, fewer or
// more entries than it says, a matrix of no rows or columns; and where it does not fit the memory.
//
// Source: Boisvert, Pozo and Remington, The Matrix Market exchange formats: initial design (NISTIR 5935, 1996).
MarketMatrix read_matrix_market(const std::string& path);

}  // namespace lockstep::linear
