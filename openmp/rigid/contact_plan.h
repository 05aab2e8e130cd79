// The order in which contacts stand in vectors of sixteen, and which vectors stand between two barriers.
//
// Within a batch, contacts with as many points stand side by side, so that few lanes wait for others' points; the order
// within a batch does not change the bits. This is a counting sort in pieces: each piece counts its contacts, one
// thread adds up, and each piece then knows where its contacts go. A piece is whole vectors of one batch, so the plan
// is the same whoever makes the pieces.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/batches.h"
#include "common/rigid/manifold.h"
#include "common/simd.h"
#include "openmp/stages.h"

namespace lockstep::rigid::openmp {

using lockstep::openmp::add_batch, lockstep::openmp::Stage;

inline constexpr int small_batch = 4;          // vectors: less than what a barrier costs
inline constexpr int piece_size = 32 * lanes;  // contacts: a thousand pieces are added up in some microseconds

struct Plan {
  struct Vector {
    int first, count;  // contacts order[first] .. order[first + count - 1]
  };
  // Contacts begin .. end - 1 of `batches.order`, all of one batch.
  struct Piece {
    int batch, begin, end;
    int first_vector;           // the vector that holds its first contacts
    int next[most_points + 1];  // [points fewer than most]: how many there are, then where the next of them goes
  };

  std::vector<std::int32_t> order;  // manifolds, batch after batch
  std::vector<Vector> vectors;
  std::vector<Stage> stages;  // in vectors
  std::vector<Piece> pieces;
};

// Cuts batches into pieces, vectors and stages. Keeps the memory of the plan before.
inline void cut(const Batches& batches, Plan& plan) {
  plan.pieces.clear(), plan.stages.clear();
  int vectors = 0;
  for (int k = 0; k < batches.count(); ++k) {
    const int begin = vectors, end_of_batch = batches.begin[k + 1];
    for (int first = batches.begin[k]; first < end_of_batch; first += piece_size) {
      const int last = std::min(first + piece_size, end_of_batch);
      plan.pieces.push_back({k, first, last, vectors, {}});
      vectors += (last - first + lanes - 1) / lanes;
    }
    const bool small = vectors - begin < small_batch;
    add_batch(begin, vectors, small, plan.stages);
  }
  plan.order.resize(batches.order.size());
  plan.vectors.resize(vectors);
}

// Adds the counts of a batch's pieces up: most points first, and of as many points the first piece first.
inline void add_up(Plan& plan) {
  const int pieces = static_cast<int>(plan.pieces.size());
  for (int first = 0, end = 0; first < pieces; first = end) {
    while (end < pieces && plan.pieces[end].batch == plan.pieces[first].batch) ++end;
    int sum = plan.pieces[first].begin;
    for (int fewer = 0; fewer <= most_points; ++fewer)
      for (int k = first; k < end; ++k) sum += std::exchange(plan.pieces[k].next[fewer], sum);
  }
}

// Orders the contacts of a plan that has been cut. Every thread of the team must call it; a barrier stands at its end.
template <class Real>
void order_by_points(const Batches& batches, std::span<const Manifold<Real>> manifolds, Plan& plan) {
  const int pieces = static_cast<int>(plan.pieces.size());
  const std::int32_t* const from = batches.order.data();
  // A piece counts for itself.
#pragma omp for schedule(static)
  for (int k = 0; k < pieces; ++k) {
    Plan::Piece& piece = plan.pieces[k];
    for (int i = piece.begin; i < piece.end; ++i) ++piece.next[most_points - manifolds[from[i]].count];
  }
  // One thread adds up, and the others wait at the barrier that ends `single`.
#pragma omp single
  add_up(plan);
  // No two pieces have a place or a vector in common.
#pragma omp for schedule(static)
  for (int k = 0; k < pieces; ++k) {
    Plan::Piece& piece = plan.pieces[k];
    for (int i = piece.begin; i < piece.end; ++i)
      plan.order[piece.next[most_points - manifolds[from[i]].count]++] = from[i];
    for (int first = piece.begin, vector = piece.first_vector; first < piece.end; first += lanes, ++vector)
      plan.vectors[vector] = {first, std::min(lanes, piece.end - first)};
  }
}

// The order of batches as the solver goes through it (contact_solver.cpp). The plan has been cut.
template <class Real>
struct InBatches {
  const Batches& batches;
  std::span<const Manifold<Real>> manifolds;
  Plan& plan;

  void prepare() const { order_by_points(batches, manifolds, plan); }
  std::span<const std::int32_t> contacts(int vector) const {
    const auto [first, count] = plan.vectors[vector];
    return {plan.order.data() + first, static_cast<std::size_t>(count)};
  }
  // The vectors of a stage share no body that moves, or one thread takes them in order. The barrier at the end of a
  // stage makes its writes visible to the next one.
  template <class Action>
  void for_each(const Action& action) const {
    for (const Stage& stage : plan.stages) {
      if (stage.small) {
#pragma omp single
        for (int i = stage.begin; i < stage.end; ++i) action(i);
      } else {
#pragma omp for schedule(static)
        for (int i = stage.begin; i < stage.end; ++i) action(i);
      }
    }
  }
};

}  // namespace lockstep::rigid::openmp
