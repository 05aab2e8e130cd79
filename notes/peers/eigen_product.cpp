// Eigen: products of a sparse matrix, compressed rows in float, and a vector.
#include <eigen3/Eigen/Sparse>

#include <cmath>
#include <filesystem>

#include "common/linear/multiply.h"
#include "notes/peers/peer.h"
#include "verify/linear/inputs.h"

namespace lockstep::peers {
namespace {

// The largest error of an element, relative to the sum of the magnitudes that it adds up.
double error(const linear::Rows<float>& a, std::span<const float> x, std::span<const float> y) {
  double worst = 0;
  for (int i = 0; i < a.rows; ++i) {
    double sum = 0, magnitudes = 0;
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      const double term = double(a.value[k]) * x[a.column[k]];
      sum += term, magnitudes += std::abs(term);
    }
    if (magnitudes > 0) worst = std::max(worst, std::abs(y[i] - sum) / magnitudes);
  }
  return worst;
}

void compare(Json& rows, const Asked& asked) {
  using Matrix = Eigen::SparseMatrix<float, Eigen::RowMajor>;
  constexpr int products_of_a_turn = 20;
  for (const std::string& name : asked.scenes) {
    const auto in = verify::linear_inputs::inputs(path_of("linear", name));
    const linear::Rows<float>& a = in->scene.rows;
    const bool in_blocks = in->scene.blocks.rows > 0;
    const Matrix matrix = Eigen::Map<const Matrix>(a.rows, a.columns, Eigen::Index(a.value.size()), a.begin.data(),
                                                   a.column.data(), a.value.data());
    const Eigen::Map<const Eigen::VectorXf> x(in->x.data(), a.columns);
    Eigen::VectorXf y(a.rows);
    Array<float> our_y(a.rows);
    for (const int threads : asked.threads) {
      Eigen::setNbThreads(threads);
      const auto repeat = [](const auto& product) {
        return [=] {
          for (int k = 0; k < products_of_a_turn; ++k) product();
        };
      };
      Json row = {{"work", "a sparse product"},
                  {"scene", std::filesystem::path(name).stem().string()},
                  {"ours", in_blocks ? "linear/multiply block_rows" : "linear/multiply rows"},
                  {"items", {{"rows", a.rows}, {"entries", a.value.size()}}}};
      row.update(take_turns(threads, products_of_a_turn,
                            {[] {}, repeat([&] { y.noalias() = matrix * x; }), true},
                            {[] {}, repeat([&] {
                               if (in_blocks)
                                 linear::openmp::multiply(in->sliced_blocks, in->x, our_y);
                               else
                                 linear::openmp::multiply(in->sliced, in->x, our_y);
                             })}));
      row["quality"] = {{"error_of_sums", error(a, in->x, {y.data(), std::size_t(a.rows)})}};
      row["ours_quality"] = {{"error_of_sums", error(a, in->x, our_y)}};
      row["not_the_same"] = std::string("Both in float. Eigen reads compressed rows; ours ") +
                            (in_blocks ? "3 x 3 blocks, one column for nine values."
                                       : "slices of sixteen rows that store equal values and runs of columns once.");
      rows.push_back(row);
    }
  }
}

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep::peers;
  return report([&](Json& rows) { compare(rows, asked(count, words)); });
}
