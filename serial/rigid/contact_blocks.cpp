// Cuts contacts into blocks of space.
//
// Most contacts of a pile are between bodies that are near each other on a space-filling curve. If the curve is cut
// into 64 pieces, nine contacts in ten of a large pile (castles_4) lie within one, and each thread solves its own. The
// others are cut again, along a curve that is shifted.
//
// The contract stands in common/rigid/contact_blocks.h.
#include "common/rigid/contact_blocks.h"

#include <numeric>

#include "common/real.h"

namespace lockstep::rigid::serial {

using spatial::Box, spatial::around;

void contact_blocks(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                    const Bodies<Real>& bodies, ContactBlocks& blocks) {
  const int contacts = static_cast<int>(manifolds.size());
  std::vector<Ends> ends(contacts);
  Box<Real> bounds = spatial::empty_box<Real>;
  for (int k = 0; k < contacts; ++k) {
    const auto moving = [&](std::int32_t collider) {
      const std::int32_t i = body[collider];
      if (!(bodies.inverse_mass[i].w > 0)) return -1;
      bounds = around(bounds, {bodies.pose[i].position, bodies.pose[i].position});
      return i;
    };
    ends[k] = {moving(manifolds[k].a), moving(manifolds[k].b)};
  }

  blocks.order.clear(), blocks.groups.clear(), blocks.blocks.clear(), blocks.rounds.clear();
  const auto close = [&](std::span<const std::int32_t> group) {
    blocks.groups.push_back(static_cast<std::int32_t>(blocks.order.size()));
    blocks.order.insert(blocks.order.end(), group.begin(), group.end());
  };
  std::vector<std::uint64_t> taken(bodies.count, 0);
  std::vector<std::int32_t> code(bodies.count), left(contacts), across;
  std::iota(left.begin(), left.end(), 0);
  for (int round = 0; !left.empty(); ++round) {
    const Curve<Real> curve = curve_of_round(bounds, round);
    for (const std::int32_t contact : left)
      for (const std::int32_t i : {ends[contact].a, ends[contact].b})
        if (i >= 0) code[i] = curve.code(bodies.pose[i].position);
    const auto code_of_contact = [&](std::int32_t contact) { return code_of(ends[contact], code.data()); };
    std::ranges::stable_sort(left, {}, code_of_contact);

    const int n = static_cast<int>(left.size()), count = blocks_of_round(round, n);
    blocks.rounds.push_back(static_cast<std::int32_t>(blocks.blocks.size()));
    across.clear();
    for (int block = 0, k = 0; block < count; ++block) {
      const CodeRange range = range_of_block(block, count, n, [&](int i) { return code_of_contact(left[i]); });
      blocks.blocks.push_back(static_cast<std::int32_t>(blocks.groups.size()));
      OpenGroups groups(ends, taken.data(), close);
      for (; k < n && code_of_contact(left[k]) < range.last; ++k) {
        if (range.has(ends[left[k]], code.data()))
          groups.add(left[k]);
        else
          across.push_back(left[k]);
      }
      groups.close_all();
    }
    left.swap(across);
  }
  blocks.groups.push_back(contacts);
  blocks.blocks.push_back(static_cast<std::int32_t>(blocks.groups.size()) - 1);
  blocks.rounds.push_back(static_cast<std::int32_t>(blocks.blocks.size()) - 1);
}

}  // namespace lockstep::rigid::serial
