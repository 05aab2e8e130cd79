// Cuts contacts into blocks of space.
//
// The algorithm stands in serial/rigid/contact_blocks.cpp. All rounds are one parallel region. A round sorts the
// contacts that are left by code, in parallel. Then each block is one thread's. The thread puts the block's contacts
// into groups, and stores them, and those that cross its border, at the places that the block had among the sorted.
// Sums over the blocks before say where they belong, and the thread copies them.
//
// The contract stands in common/rigid/contact_blocks.h.
#include "common/rigid/contact_blocks.h"

#include "common/real.h"
#include "openmp/rigid/lanes.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using lockstep::openmp::my_share;
using spatial::Box, spatial::around, spatial::openmp::grow, spatial::openmp::Keyed;

static_assert(group_size == lanes);

// A block of the round. From place `first` on, `grouped` holds its contacts, `sizes` how many each of its groups has,
// and `across` the contacts that cross its border.
struct Block {
  int first, contacts, groups, across;
};

// The calling thread's own, kept from call to call (openmp/spatial/workspace.h says why).
struct Memory {
  Array<Ends> ends;                            // [contact]
  Array<std::int32_t> code;                    // [body]
  Array<std::uint64_t> taken;                  // [thread][padded(bodies)]: 0 between calls; no line is two threads'
  Array<std::int32_t> left;                    // contacts
  Array<std::int32_t> grouped, sizes, across;  // of the blocks of a round
  std::vector<Box<Real>> bounds;               // [thread]
};
Memory& own_memory() {
  thread_local Memory mine;
  return mine;
}

// Reads the share of the calling thread of the team. Returns the box around its bodies that move.
Box<Real> read_contacts(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                        const Bodies<Real>& bodies, Memory& memory) {
  const int contacts = static_cast<int>(manifolds.size());
  Box<Real> bounds = spatial::empty_box<Real>;
  // Each contact belongs to one thread.
#pragma omp for schedule(static) nowait
  for (int k = 0; k < contacts; ++k) {
    const auto moving = [&](std::int32_t collider) {
      const std::int32_t i = body[collider];
      if (!(bodies.inverse_mass[i].w > 0)) return -1;
      bounds = around(bounds, {bodies.pose[i].position, bodies.pose[i].position});
      return i;
    };
    memory.ends[k] = {moving(manifolds[k].a), moving(manifolds[k].b)};
    memory.left[k] = k;
  }
  return bounds;
}

// Puts the contacts of block `block` of `count` of the n that are sorted into groups.
Block group_contacts(int block, int count, int n, const Keyed* sorted, std::uint64_t* taken, Memory& memory) {
  const auto code = [&](int k) { return static_cast<std::int32_t>(sorted[k].key); };
  const CodeRange range = range_of_block(block, count, n, code);
  const auto begin_of = [&](std::int32_t bound) {
    return static_cast<int>(
        std::ranges::lower_bound(sorted, sorted + n, static_cast<std::uint32_t>(bound), {}, &Keyed::key) - sorted);
  };
  const int first = begin_of(range.first);
  Block mine = {first, 0, 0, 0};
  OpenGroups groups(std::span<const Ends>(memory.ends), taken, [&](std::span<const std::int32_t> group) {
    std::ranges::copy(group, &memory.grouped[first + mine.contacts]);
    mine.contacts += static_cast<int>(group.size());
    memory.sizes[first + mine.groups++] = static_cast<std::int32_t>(group.size());
  });
  for (int k = first; k < n && code(k) < range.last; ++k) {
    const std::int32_t contact = sorted[k].element;
    if (range.has(memory.ends[contact], memory.code.data()))
      groups.add(contact);
    else
      memory.across[first + mine.across++] = contact;
  }
  groups.close_all();
  return mine;
}

// How much the first `count` blocks have.
Block sum_of(const std::vector<Block>& blocks, int count) {
  Block sum = {};
  for (int k = 0; k < count; ++k)
    sum.contacts += blocks[k].contacts, sum.groups += blocks[k].groups, sum.across += blocks[k].across;
  return sum;
}

// Copies what a block has to places contact, group and across of the result and of the contacts that are left.
void copy_block(const Block& block, int contact, int group, int across, Memory& memory, ContactBlocks& blocks) {
  std::copy_n(&memory.grouped[block.first], block.contacts, &blocks.order[contact]);
  std::copy_n(&memory.across[block.first], block.across, &memory.left[across]);
  for (int k = 0; k < block.groups; ++k) {
    blocks.groups[group + k] = contact;
    contact += memory.sizes[block.first + k];
  }
}

}  // namespace

void contact_blocks(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                    const Bodies<Real>& bodies, ContactBlocks& blocks) {
  const int contacts = static_cast<int>(manifolds.size());
  Memory& memory = own_memory();
  grow(memory.ends, contacts), grow(memory.left, contacts), grow(memory.grouped, contacts);
  grow(memory.sizes, contacts), grow(memory.across, contacts);
  grow(memory.code, padded(bodies.count)), grow(memory.taken, padded(bodies.count) * omp_get_max_threads());
  Array<Keyed>&keyed = spatial::openmp::workspace().radix_sort.keyed,
  &other = spatial::openmp::workspace().radix_sort.other;
  grow(keyed, contacts), grow(other, contacts);
  memory.bounds.assign(omp_get_max_threads(), spatial::empty_box<Real>);
  spatial::openmp::RadixSort sort;
  // So that nothing is allocated within the region.
  blocks.order.resize(contacts);
  blocks.groups.reserve(contacts + 1);
  blocks.blocks.reserve(most_rounds * most_blocks + 1), blocks.rounds.reserve(most_rounds + 1);
  blocks.groups.clear(), blocks.blocks.clear(), blocks.rounds.clear();
  std::vector<Block> made(most_blocks);

  // A body, contact or block belongs to one thread in each loop; barriers stand between one thread's writing and
  // another's reading. Each thread has its own open groups.
#pragma omp parallel
  {
    memory.bounds[omp_get_thread_num()] = read_contacts(manifolds, body, bodies, memory);
#pragma omp barrier
    Box<Real> bounds = spatial::empty_box<Real>;
    for (const Box<Real>& part : memory.bounds) bounds = around(bounds, part);
    std::uint64_t* const taken = &memory.taken[padded(bodies.count) * omp_get_thread_num()];
    Block before = {};  // of all rounds before; every thread adds up for itself
    for (int round = 0, n = contacts; n > 0; ++round) {
      const Curve<Real> curve = curve_of_round(bounds, round);
#pragma omp for schedule(static)
      for (int i = 0; i < bodies.count; i += lanes)
        store(&memory.code[i], curve.code(load_position(bodies.pose, sixteen(i))));
      const lockstep::openmp::Share mine = my_share(n);
      Keyed *from = keyed.data(), *to = other.data();
      for (int k = mine.begin; k < mine.end; ++k) {
        const std::int32_t contact = memory.left[k];
        from[k] = {static_cast<std::uint32_t>(code_of(memory.ends[contact], memory.code.data())), contact};
      }
      sort(n, spatial::morton_bits, from, to);

      const int count = blocks_of_round(round, n);
#pragma omp for schedule(static)
      for (int block = 0; block < count; ++block) made[block] = group_contacts(block, count, n, from, taken, memory);
      const Block all = sum_of(made, count);
      // One thread makes room; the others wait at the barrier that ends `single`.
#pragma omp single
      {
        blocks.rounds.push_back(static_cast<std::int32_t>(blocks.blocks.size()));
        for (int block = 0; block < count; ++block) blocks.blocks.push_back(before.groups + sum_of(made, block).groups);
        blocks.groups.resize(before.groups + all.groups);
      }
#pragma omp for schedule(static)
      for (int block = 0; block < count; ++block) {
        const Block lesser = sum_of(made, block);
        copy_block(made[block], before.contacts + lesser.contacts, before.groups + lesser.groups, lesser.across, memory,
                   blocks);
      }
      before = {0, before.contacts + all.contacts, before.groups + all.groups, 0};
      n = all.across;
    }
  }
  blocks.groups.push_back(contacts);
  blocks.blocks.push_back(static_cast<std::int32_t>(blocks.groups.size()) - 1);
  blocks.rounds.push_back(static_cast<std::int32_t>(blocks.blocks.size()) - 1);
}

}  // namespace lockstep::rigid::openmp
