// Contacts matched from step to step, against a look-up that follows the contract word for word.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "common/rigid/match_contacts.h"
#include "tests/contact_problems.h"

namespace lockstep::rigid::contacts {
namespace {

// Some pairs of 40 colliders, with 1 to 4 points of different features at random places.
template <class Real>
void some_contacts(std::mt19937& random, int every, Array<Manifold<Real>>& manifolds, Array<Impulses<Real>>& impulses) {
  std::uniform_real_distribution<Real> uniform(-1, 1);
  manifolds.clear(), impulses.clear();
  for (int a = 0; a < 40; ++a)
    for (int b = a + 1; b < 40; ++b) {
      if (random() % every != 0) continue;
      Manifold<Real>& m = manifolds.emplace_back();
      Impulses<Real>& i = impulses.emplace_back();
      m = {}, i = {};
      m.a = a, m.b = b, m.normal = {0, 1, 0}, m.count = 1 + random() % 4;
      std::vector<std::int32_t> features = {11, 12, 13, 14, 15, 16};
      std::ranges::shuffle(features, random);
      for (int k = 0; k < m.count; ++k) {
        m.feature[k] = features[k];
        m.point[k] = {{Real(.02) * uniform(random), Real(.02) * uniform(random), 0}, 0};
        i.normal[k] = uniform(random), i.tangent[k] = uniform(random), i.bitangent[k] = uniform(random);
      }
    }
}

// The look-up follows the contract word for word.
template <class Real>
Array<Impulses<Real>> looked_up(const Array<Manifold<Real>>& last, const Array<Impulses<Real>>& from,
                                const Array<Manifold<Real>>& manifolds) {
  std::map<std::pair<int, int>, std::size_t> where;
  for (std::size_t j = 0; j < last.size(); ++j) where[{last[j].a, last[j].b}] = j;
  Array<Impulses<Real>> result;
  for (const Manifold<Real>& m : manifolds) {
    Impulses<Real>& impulses = result.emplace_back();
    impulses = {};
    if (!where.contains({m.a, m.b})) continue;
    const Manifold<Real>& old = last[where[{m.a, m.b}]];
    const Impulses<Real>& old_impulses = from[where[{m.a, m.b}]];
    std::map<int, int> source;  // the old point of point k
    std::set<int> left;
    for (int j = 0; j < old.count; ++j) {
      const auto same = std::find(m.feature, m.feature + m.count, old.feature[j]);
      if (same < m.feature + m.count)
        source[static_cast<int>(same - m.feature)] = j;
      else
        left.insert(j);
    }
    for (int k = 0; k < m.count; ++k) {
      if (source.contains(k) || left.empty()) continue;
      const auto squared = [&](int j) {
        const Vector3<Real> off = m.point[k].position - old.point[j].position;
        return dot(off, off);
      };
      const int nearest = *std::ranges::min_element(left, {}, squared);
      if (squared(nearest) < static_cast<Real>(same_place * same_place)) source[k] = nearest, left.erase(nearest);
    }
    for (const auto& [k, j] : source)
      impulses.normal[k] = old_impulses.normal[j], impulses.tangent[k] = old_impulses.tangent[j],
      impulses.bitangent[k] = old_impulses.bitangent[j];
  }
  return result;
}

TEST(MatchContacts, FindsTheSamePairAndFeatureOrTheNearestPoint) {
  std::mt19937 random(5);
  for (const int last_every : {1, 2, 20, 1000})
    for (const int every : {1, 3, 20, 1000}) {
      Array<Manifold<float>> last, now;
      Array<Impulses<float>> from, unused;
      some_contacts(random, last_every, last, from);
      some_contacts(random, every, now, unused);
      const Array<Impulses<float>> expected = looked_up(last, from, now);
      const auto garbage = [&] {
        return Array<Impulses<float>>(now.size(), {{7, 7, 7, 7}, {7, 7, 7, 7}, {7, 7, 7, 7}, {7, 7, 7, 7}});
      };
      Array<Impulses<float>> impulses = garbage();
      serial::match_contacts(last, from, now, impulses);
      EXPECT_TRUE(same_bits(impulses, expected)) << last_every << ' ' << every;
      for (const int threads : thread_counts) {
        omp_set_num_threads(threads);
        impulses = garbage();
        openmp::match_contacts(last, from, now, impulses);
        EXPECT_TRUE(same_bits(impulses, expected)) << last_every << ' ' << every << ' ' << threads;
      }
    }
}

}  // namespace
}  // namespace lockstep::rigid::contacts
