// hypre (LLNL): conjugate gradients on a structured grid, preconditioned by a cycle of its multigrid for such grids,
// PFMG. Cells that are not liquid are rows of the identity, since its grids are boxes.
#include <HYPRE_struct_ls.h>
#include <mpi.h>

#include <stdexcept>
#include <vector>

#include "notes/peers/pressure.h"
#include "verify/program.h"

namespace lockstep::peers {
namespace {

void check(int error) {
  if (error) throw std::runtime_error("hypre: error " + std::to_string(error));
}

class Hypre {
 public:
  explicit Hypre(const Problem& problem) : problem_(problem) {
    const auto& cells = problem.system.cells;
    last_[0] = cells.nx - 1, last_[1] = cells.ny - 1, last_[2] = cells.nz - 1;
    HYPRE_StructGrid grid;
    check(HYPRE_StructGridCreate(MPI_COMM_WORLD, 3, &grid));
    check(HYPRE_StructGridSetExtents(grid, first_, last_));
    check(HYPRE_StructGridAssemble(grid));
    HYPRE_StructStencil stencil;
    constexpr int entries = 4;
    int offsets[entries][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // the other half is its mirror image
    check(HYPRE_StructStencilCreate(3, entries, &stencil));
    for (int k = 0; k < entries; ++k) check(HYPRE_StructStencilSetElement(stencil, k, offsets[k]));
    check(HYPRE_StructMatrixCreate(MPI_COMM_WORLD, grid, stencil, &matrix_));
    check(HYPRE_StructMatrixSetSymmetric(matrix_, 1));
    check(HYPRE_StructMatrixInitialize(matrix_));
    std::vector<double> values, right;
    const auto& diagonal = problem.system.diagonal;
    for (int z = 0; z < cells.nz; ++z)
      for (int y = 0; y < cells.ny; ++y)
        for (int x = 0; x < cells.nx; ++x) {
          const std::size_t at = cells.index(x, y, z);
          const bool liquid = diagonal[at] > 0;
          values.push_back(liquid ? diagonal[at] : 1.);
          for (const std::ptrdiff_t step : {std::ptrdiff_t(1), cells.line(), cells.plane()})
            values.push_back(liquid && diagonal[at + step] > 0 ? -1. : 0.);
          right.push_back(liquid ? problem.system.right[at] : 0.);
        }
    int which[entries] = {0, 1, 2, 3};
    check(HYPRE_StructMatrixSetBoxValues(matrix_, first_, last_, entries, which, values.data()));
    check(HYPRE_StructMatrixAssemble(matrix_));
    for (HYPRE_StructVector* vector : {&b_, &x_}) {
      check(HYPRE_StructVectorCreate(MPI_COMM_WORLD, grid, vector));
      check(HYPRE_StructVectorInitialize(*vector));
    }
    check(HYPRE_StructVectorSetBoxValues(b_, first_, last_, right.data()));
    check(HYPRE_StructVectorAssemble(b_));
    check(HYPRE_StructVectorAssemble(x_));
  }

  Answer solve() {
    const double start = verify::now();
    HYPRE_StructSolver cycle, solver;
    check(HYPRE_StructPFMGCreate(MPI_COMM_WORLD, &cycle));
    HYPRE_StructPFMGSetMaxIter(cycle, 1);
    HYPRE_StructPFMGSetTol(cycle, 0);
    HYPRE_StructPFMGSetZeroGuess(cycle);
    HYPRE_StructPFMGSetRelaxType(cycle, 2);  // red-black Gauss-Seidel, symmetric: fewer iterations than Jacobi's
    HYPRE_StructPFMGSetNumPreRelax(cycle, 1);
    HYPRE_StructPFMGSetNumPostRelax(cycle, 1);
    check(HYPRE_StructPCGCreate(MPI_COMM_WORLD, &solver));
    HYPRE_StructPCGSetTol(solver, problem_.tolerance);
    HYPRE_StructPCGSetTwoNorm(solver, 1);
    HYPRE_StructPCGSetMaxIter(solver, 1000);
    HYPRE_StructPCGSetPrecond(solver, HYPRE_StructPFMGSolve, HYPRE_StructPFMGSetup, cycle);
    check(HYPRE_StructVectorSetConstantValues(x_, 0));
    check(HYPRE_StructPCGSetup(solver, matrix_, b_, x_));
    Answer answer;
    answer.setup_s = verify::now() - start;
    check(HYPRE_StructPCGSolve(solver, matrix_, b_, x_));
    HYPRE_StructPCGGetNumIterations(solver, &answer.iterations);
    HYPRE_StructPCGDestroy(solver);
    HYPRE_StructPFMGDestroy(cycle);
    const auto& cells = problem_.system.cells;
    std::vector<double> values(std::size_t(cells.nx) * cells.ny * cells.nz);
    check(HYPRE_StructVectorGetBoxValues(x_, first_, last_, values.data()));
    for (int z = 0, k = 0; z < cells.nz; ++z)
      for (int y = 0; y < cells.ny; ++y)
        for (int x = 0; x < cells.nx; ++x, ++k)
          if (problem_.system.diagonal[cells.index(x, y, z)] > 0) answer.x.push_back(values[k]);
    return answer;
  }

 private:
  const Problem& problem_;
  int first_[3] = {0, 0, 0}, last_[3];
  HYPRE_StructMatrix matrix_;
  HYPRE_StructVector b_, x_;
};

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep;
  using namespace lockstep::peers;
  MPI_Init(nullptr, nullptr);
  const int code = report([&](Json& rows) {
    compare_solvers(
        rows, asked(count, words), "multigrid", production_fluid::openmp::pressure_solve_multigrid,
        [](const Problem& problem, int) {
          const auto hypre = std::make_shared<Hypre>(problem);
          return [hypre] { return hypre->solve(); };
        },
        "hypre in double, ours in float with a sum and residuals in double. hypre's grid is the whole box, with rows of"
        " the identity where no liquid is. Each solve makes its hierarchy anew, in both. One process: hypre's threads"
        " would be processes of MPI, as Debian builds it.");
  });
  MPI_Finalize();
  return code;
}
