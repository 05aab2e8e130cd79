// Contacts answered batch after batch, or all at once: the loops that repulsions and impulses share.
//
// Batches. Contacts of a batch share no vertex that moves: sixteen at once, shared out to threads. The last batches
// hold a few contacts each; one thread takes several of them in a row, which needs no barrier between them.
//
// All at once. Contacts write impulses, and each vertex adds up its own, from lists of where it stands in contacts: no
// two threads write to one place, and sums are in the order of contacts.
//
// Serial twin: serial/production_cloth/respond_in_order.h.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/counting_sort.h"
#include "common/production_cloth/contact_batches.h"
#include "openmp/production_cloth/contact_lanes.h"
#include "openmp/share.h"
#include "openmp/stages.h"

namespace lockstep::production_cloth::openmp {

using lockstep::openmp::add_batch, lockstep::openmp::my_share;
using lockstep::openmp::Share, lockstep::openmp::Stage;

constexpr int small_batch = 64;  // contacts: less work than what a barrier costs

inline std::vector<Stage> stages_of(const Batches& batches) {
  std::vector<Stage> stages;
  for (int batch = 0; batch < batches.count(); ++batch) {
    const bool small = batches.begin[batch + 1] - batches.begin[batch] < small_batch;
    add_batch(batch, batch + 1, small, stages);
  }
  return stages;
}

constexpr int few = 4;  // contacts: sixteen lanes take as long as these one by one

// One contact.
template <class GainOf>
void respond_to_one(const Contacts<float>& contacts, std::size_t k, const GainOf& gain_of, float friction,
                    Quad* records) {
  Touching<float> c;
  const std::int32_t* const corner = &contacts.corner[4 * k];
  for (int i = 0; i < 4; ++i) {
    const auto& [x, y, z, inverse_mass] = records[corner[i]].field;
    c.weight[i] = contacts.weight[4 * k + i], c.velocity[i] = {x, y, z}, c.inverse_mass[i] = inverse_mass;
  }
  const float* const normal = &contacts.normal[4 * k];
  c.normal = {normal[0], normal[1], normal[2]}, c.distance = normal[3];
  const Vector3<float> impulse = respond(c, gain_of, friction).impulse;
  for (int i = 0; i < 4; ++i) {
    const Vector3<float> v = c.velocity[i] + (c.weight[i] * c.inverse_mass[i]) * impulse;
    if (c.inverse_mass[i] > 0) records[corner[i]] = {{v.x, v.y, v.z, c.inverse_mass[i]}};
  }
}

// Contacts order[k] .. order[k + 15] of one batch, which has `left` from k on. Lanes beyond repeat the first, and write
// what it writes.
template <class GainOf>
LOCKSTEP_INLINE void respond_to(const Contacts<float>& contacts, const std::int32_t* order, int k, int left,
                                const GainOf& gain_of, float friction, Quad* records) {
  if (left <= few) {
    for (int l = 0; l < left; ++l) respond_to_one(contacts, order[k + l], gain_of, friction, records);
    return;
  }
  Places rest;
  const std::int32_t* which = order + k;
  if (left < lanes) {
    const maskv inside = first_lanes(left);
    rest = places_of(select(inside, load(which, inside), *which)), which = rest.place;
  }
  const auto [c, corner] = load_contacts(contacts, 0, which, records);
  const Vector3<floatv> impulse = respond<floatv>(c, gain_of, friction).impulse;
  for (int i = 0; i < 4; ++i) {
    const Vector3<floatv> v = c.velocity[i] + (c.weight[i] * c.inverse_mass[i]) * impulse;
    store_quads(records, corner[i], {{v.x, v.y, v.z, c.inverse_mass[i]}}, c.inverse_mass[i] > 0.f);
  }
}

template <class GainOf>
void respond_in_batches(const Contacts<float>& contacts, const GainOf& gain_of, float friction,
                        const Array<float>& inverse_mass, Vectors<float>& velocity) {
  if (contacts.count == 0) return;
  const Batches batches = make_contact_batches(contacts, inverse_mass);
  const std::vector<Stage> stages = stages_of(batches);
  const auto memory = std::make_unique_for_overwrite<Quad[]>(inverse_mass.size());
  Quad* const records = memory.get();
  const std::int32_t* const order = batches.order.data();
#pragma omp parallel
  {
    make_records(velocity, inverse_mass, records);
    for (const Stage& stage : stages) {
      const int begin = batches.begin[stage.begin], end = batches.begin[stage.end];
      if (stage.small) {
        // One thread takes them in order; the barrier at the end shows the others what it wrote.
#pragma omp single
        for (int batch = stage.begin; batch < stage.end; ++batch)
          for (int k = batches.begin[batch]; k < batches.begin[batch + 1]; k += lanes)
            respond_to(contacts, order, k, batches.begin[batch + 1] - k, gain_of, friction, records);
      } else {
        // Contacts of a batch share no vertex that moves, and others are not written. The barrier ends the batch.
#pragma omp for schedule(static)
        for (int k = begin; k < end; k += lanes) respond_to(contacts, order, k, end - k, gain_of, friction, records);
      }
    }
    read_records(records, velocity);
  }
}

// Where vertices stand in one thread's share of the contacts: vertex v is corners slot[begin[v]] .. slot[begin[v + 1] -
// 1], in ascending order. Corner 4 k + i is corner i of contact k. With one list of all threads, corners of a vertex
// would stand side by side, whichever thread they are of, and cores would pass the cache lines to and fro.
struct Corners {
  std::int32_t* slot;
  std::vector<std::int32_t> begin;
};

// What the impulses of vertices v .. v + 15 sum up to, each in the order of contacts. A contact's numbers are added at
// once: left alone, g++ gathers one number of several contacts, and takes 1.4 times as long.
LOCKSTEP_INLINE Vector3<floatv> sums_at(int v, std::span<const Corners> of_threads, const Contacts<float>& contacts,
                                        const Quad* response) {
  using Four = float __attribute__((vector_size(sizeof(Quad))));
  alignas(array_alignment) float sums[3][lanes] = {};
  for (const Corners& corners : of_threads) {
    const std::int32_t* const begin = &corners.begin[v];
    if (begin[0] == begin[lanes]) continue;  // of many threads, most have no corner at sixteen vertices
    for (int l = 0; l < lanes; ++l) {
      Four sum = {sums[0][l], sums[1][l], sums[2][l], 0};
      for (int k = begin[l]; k < begin[l + 1]; ++k) {
        const std::int32_t s = corners.slot[k];
        sum += contacts.weight[s] * *reinterpret_cast<const Four*>(response[s / 4].field);
      }
      for (int i = 0; i < 3; ++i) sums[i][l] = sum[i];
    }
  }
  return {load(sums[0]), load(sums[1]), load(sums[2])};
}

template <class GainOf>
void respond_at_once(const Contacts<float>& contacts, const GainOf& gain_of, float friction,
                     const Array<float>& inverse_mass, Vectors<float>& velocity) {
  const int count = static_cast<int>(contacts.count), vertices = static_cast<int>(inverse_mass.size());
  const auto response_memory = std::make_unique_for_overwrite<Quad[]>(padded(count));  // impulse and gain
  const auto memory = std::make_unique_for_overwrite<Quad[]>(inverse_mass.size());
  Quad *const response = response_memory.get(), *const records = memory.get();
  const auto slots = std::make_unique_for_overwrite<std::int32_t[]>(4 * contacts.count);
  std::vector<Corners> corners(omp_get_max_threads());  // [thread]
  for (Corners& each : corners) each.begin.reserve(vertices + 2);
  // A thread sorts its own share of the corners. Others read it behind the barriers of the loops.
#pragma omp parallel
  {
    const Share mine = my_share(4 * count);
    Corners& own = corners[omp_get_thread_num()];
    own.slot = slots.get() + mine.begin;
    const auto for_each_corner = [mine, vertex = contacts.corner.data()](const auto& visit) {
      for (int s = mine.begin; s < mine.end; ++s) visit(s, vertex[s]);
    };
    stable_counting_sort(
        vertices, for_each_corner, [slot = own.slot](int s, std::int32_t place) { slot[place] = s; }, own.begin);
    const std::span of_threads = std::span(std::as_const(corners)).first(omp_get_num_threads());
    make_records(velocity, inverse_mass, records);
    // A contact writes its own response, from velocities that nobody changes.
#pragma omp for schedule(static)
    for (int k = 0; k < count; k += lanes) {
      const auto [c, corner] = load_sixteen(contacts, k, records);
      const Response<floatv> r = respond<floatv>(c, gain_of, friction);
      store_sixteen_quads(response[k].field, {{r.impulse.x, r.impulse.y, r.impulse.z, r.gain}});
    }
    // Sixteen vertices write their own changes; they read responses, which are all there.
#pragma omp for schedule(static)
    for (int v = 0; v < vertices; v += lanes) {
      const Vector3<floatv> change = load(&inverse_mass[v]) * sums_at(v, of_threads, contacts, response);
      store_sixteen_quads(records[v].field, {{change.x, change.y, change.z, 0.f}});
    }
    // A contact writes its own response, from changes that are all there.
#pragma omp for schedule(static)
    for (int k = 0; k < count; k += lanes) {
      const auto [c, corner] = load_sixteen(contacts, k, records);
      const auto [x, y, z, gain] = load_sixteen_quads(response[k].field).field;
      const floatv kept = share_kept(gain, dot(c.normal, weighted(c.weight, c.velocity)));
      store_sixteen_quads(response[k].field, {{kept * x, kept * y, kept * z, gain}});
    }
    // Sixteen vertices write their own velocities; they read responses, which are all there.
    const Vector3<float*> to = pointers(velocity);
#pragma omp for schedule(static)
    for (int v = 0; v < vertices; v += lanes)
      store(to, v, load(to, v) + load(&inverse_mass[v]) * sums_at(v, of_threads, contacts, response));
  }
}

}  // namespace lockstep::production_cloth::openmp
