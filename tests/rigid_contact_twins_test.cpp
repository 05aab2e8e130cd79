// Both versions of the contact solver against each other, bit by bit.
#include <gtest/gtest.h>
#include <omp.h>

#include <cstdint>

#include "tests/contact_problems.h"

namespace lockstep::rigid::contacts {
namespace {

void expect_same_bits(const SolverSettings& settings, const Problem<float>& problem) {
  Problem<float> original = problem, batched = problem;
  solve_original(settings, original);
  solve_batches(settings, batched);
  const Batches batches = serial::batches(problem.manifolds, problem.body, problem.bodies);
  ContactBlocks blocks;
  serial::contact_blocks(problem.manifolds, problem.body, problem.bodies, blocks);
  Problem<float> cut = problem;
  serial::contact_solver_blocks(settings, cut.manifolds, cut.body, blocks, cut.bodies, cut.impulses, cut.moving);
  for (const int threads : thread_counts) {
    omp_set_num_threads(threads);
    const auto expect = [&](const Problem<float>& expected, const Problem<float>& p, const char* form) {
      EXPECT_TRUE(same_bits(expected.bodies.motion, p.bodies.motion))
          << form << ' ' << problem.manifolds.size() << ' ' << threads;
      EXPECT_TRUE(same_bits(expected.moving, p.moving)) << form << ' ' << problem.manifolds.size() << ' ' << threads;
      EXPECT_TRUE(same_bits(expected.impulses, p.impulses))
          << form << ' ' << problem.manifolds.size() << ' ' << threads;
    };
    Problem<float> p = problem;
    openmp::contact_solver_original(settings, p.manifolds, p.body, p.bodies, p.impulses, p.moving);
    expect(original, p, "original");
    p = problem;
    openmp::contact_solver_batches(settings, p.manifolds, p.body, batches, p.bodies, p.impulses, p.moving);
    expect(batched, p, "batches");
    p = problem;
    openmp::contact_solver_blocks(settings, p.manifolds, p.body, blocks, p.bodies, p.impulses, p.moving);
    expect(cut, p, "blocks");
  }
}

const SolverSettings as_usual{.time_step = 1 / 60., .gravity = {.1, -g, .2}};

TEST(ContactTwins, OfAnyNumberOfContacts) {
  expect_same_bits(as_usual, Problem<float>{});
  unsigned seed = 1;
  for (const int contacts : {0, 1, 2, 15, 16, 17, 33, 200})
    expect_same_bits(as_usual, crowd(2 + contacts, contacts, .2, seed++));
  expect_same_bits({.time_step = .02,
                    .gravity = {0, -g, 0},
                    .substeps = 2,
                    .biased_sweeps = 2,
                    .relax_sweeps = 3,
                    .bounce_from = .1},
                   crowd(100, 300, .1, seed++));
  expect_same_bits({.time_step = .02, .gravity = {0, -g, 0}, .substeps = 1, .biased_sweeps = 0, .relax_sweeps = 0},
                   crowd(100, 300, .1, seed++));
}

TEST(ContactTwins, OfManyContactsAndMostlyStaticBodies) {
  expect_same_bits(as_usual, crowd(3000, 5000, 0, 21));
  expect_same_bits(as_usual, crowd(3000, 3000, .9, 22));
  expect_same_bits(as_usual, crowd(5000, 2000, .5, 23));
}

// Every contact waits for the one before it: each batch and each level has one contact.
TEST(ContactTwins, OfOneBodyThatAllOthersTouch) {
  Problem<float> p = crowd(300, 300, 0, 31);
  for (std::size_t k = 0; k < p.manifolds.size(); ++k)
    p.manifolds[k].a = 0, p.manifolds[k].b = 2 + static_cast<std::int32_t>(k * 7 % 598);
  expect_same_bits(as_usual, p);
}

}  // namespace
}  // namespace lockstep::rigid::contacts
