// The game cloth: both versions against each other on shapes that no scene has, long runs, batches, and the schedules
// that the passes of openmp/ follow.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <random>
#include <vector>

#include "common/batches.h"
#include "common/cloth/cloths.h"
#include "common/cloth/make.h"
#include "common/cloth/residual.h"
#include "common/cloth/scene.h"
#include "openmp/cloth/schedule.h"
#include "verify/arrays.h"
#include "verify/cloth/forms.h"
#include "verify/cloth/run.h"

namespace lockstep::cloth {
namespace {

SheetPlan plan(int rows, int columns, double spacing, bool bending) {
  return {.rows = rows,
          .columns = columns,
          .origin = {0, 0, 0},
          .across = {spacing, 0, 0},
          .down = {0, -spacing, 0},
          .mass = .1,
          .bending = bending,
          .pinned = {0, columns - 1}};
}

// --- Both versions

using verify::cloth_forms;
using verify::ClothForm;

TEST(ClothTwins, AgreeToTheBitOnEveryShape) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> shift(-.004f, .004f);
  for (const auto& [rows, columns] : {std::pair{1, 33},
                                      {33, 1},
                                      {1, 2},
                                      {2, 2},
                                      {3, 5},
                                      {17, 16},
                                      {33, 47},
                                      {100, 31},
                                      {61, 130},
                                      {3, 200},
                                      {200, 3}})
    for (const bool bending : {false, true}) {
      const Model<double> model = {.time_step = 1. / 60,
                                   .substeps = 1,
                                   .iterations = 3,
                                   .gravity = {0, -9.81, 0},
                                   .wind = {1, 2, 3},
                                   .drag = 1.2,
                                   .velocity_factor = .99};
      Cloth<float> start = convert<float>(make_sheet(model, {}, plan(rows, columns, .02, bending)));
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c)
          for (Array<float>* x : {&start.position.x, &start.position.y, &start.position.z})
            (*x)[start.sheet.index(r, c)] += shift(random);
      for (const ClothForm& form : cloth_forms) {
        if (!form.openmp_step) continue;
        Cloth<float> serial = start;
        for (int step = 0; step < 2; ++step) form.serial_step(serial);
        ASSERT_EQ(verify::first_not_finite(serial), "");
        for (const int threads : {1, 2, 3, 4, 8}) {
          omp_set_num_threads(threads);
          Cloth<float> openmp = start;
          for (int step = 0; step < 2; ++step) form.openmp_step(openmp);
          EXPECT_TRUE(openmp.position.x == serial.position.x && openmp.position.y == serial.position.y &&
                      openmp.position.z == serial.position.z)
              << form.name << ' ' << rows << " x " << columns << (bending ? " bending " : " ") << threads;
        }
      }
    }
}

TEST(ClothTwins, TenThousandStepsOfTheFlagStayFinite) {
  Cloth<float> cloth = convert<float>(load_scene("scenes/cloth/flag_33.toml").cloth);
  omp_set_num_threads(2);
  for (int step = 0; step < 10000; ++step) openmp::step_chains(cloth);
  EXPECT_EQ(verify::first_not_finite(cloth), "");
  EXPECT_LT(residual(cloth), .2);
}

// --- Several cloths

// Each cloth moves as if it were alone, whichever thread takes it.
TEST(ClothTwins, ClothsSideBySideMoveAsAlone) {
  const Scene scene = load_scene("scenes/cloth/washing_line.toml");
  std::vector<Cloth<float>> start = {convert<float>(scene.cloth)};
  for (const Cloth<double>& other : scene.others) start.push_back(convert<float>(other));
  std::vector<Cloth<float>> alone = start;
  for (int step = 0; step < 20; ++step)
    for (Cloth<float>& cloth : alone)
      if (cloth.sheet.rows > 0)
        serial::step_chains(cloth);
      else
        serial::step_batches(cloth);
  for (const int threads : {1, 2, 3, 16}) {
    omp_set_num_threads(threads);
    std::vector<Cloth<float>> cloths = start;
    for (int step = 0; step < 20; ++step) openmp::step_cloths(cloths);
    for (std::size_t k = 0; k < cloths.size(); ++k)
      EXPECT_TRUE(verify::bitwise(cloths[k], alone[k]).passed) << "cloth " << k << ", threads " << threads;
  }
}

// --- Batches

TEST(Batches, AreFirstFitAndWithoutConflicts) {
  std::mt19937 random(1);
  constexpr int objects = 300, constraints = 8000;
  std::vector<std::int32_t> a, b;
  std::vector<char> movable(objects, true);
  for (int i = 0; i < objects; i += 17) movable[i] = false;
  while (a.size() < constraints) {
    const int i = random() % objects, j = random() % objects;
    if (i != j) a.push_back(i), b.push_back(j);
  }
  const Batches batches = make_batches(a, b, movable);
  std::vector<int> batch_of(constraints, -1);
  for (int k = 0; k < batches.count(); ++k)
    for (int p = batches.begin[k]; p < batches.begin[k + 1]; ++p) {
      EXPECT_EQ(batch_of[batches.order[p]], -1);
      batch_of[batches.order[p]] = k;
      if (p > batches.begin[k]) {
        EXPECT_LT(batches.order[p - 1], batches.order[p]);
      }
    }
  EXPECT_GT(batches.count(), 64);  // more than one word of bits
  const auto conflict = [&](int k, int l) {
    const auto shared = [&](int i) { return movable[i] && (i == a[l] || i == b[l]); };
    return shared(a[k]) || shared(b[k]);
  };
  for (int k = 0; k < constraints; ++k) {
    ASSERT_GE(batch_of[k], 0);
    std::vector<char> blocked(batches.count(), false);
    for (int l = 0; l < k; ++l)
      if (conflict(k, l)) blocked[batch_of[l]] = true;
    EXPECT_EQ(batch_of[k], std::find(blocked.begin(), blocked.end(), false) - blocked.begin());
  }
}

TEST(Batches, OfNothingAreNone) { EXPECT_EQ(make_batches({}, {}, {}).count(), 0); }

// --- Schedules

using namespace openmp;

bool touch(const Unit& a, const Unit& b) {
  for (int r = a.begin; r < a.end; r += a.step)
    if (r >= b.begin && r < b.end && (r - b.begin) % b.step == 0) return true;
  return false;
}

// Passes as relaxation has them: between rows one or two apart, in halves or all at once, and within rows.
Units some_units(int rows, bool halves, const std::vector<int>& downs = {1, 2, 0, 1}) {
  Units units;
  int pass = 0;
  for (const int down : downs)
    for (int half = 0; half < 2; ++half, ++pass)
      for (int r = 0; r + down < rows; ++r)
        if (!halves || down == 0 || r / down % 2 == half) units.push_back({pass, r, r + down + 1, std::max(down, 1)});
  return units;
}

// Whether a sequence holds every unit once, and those that touch a common row in the order of `units`.
void expect_in_order(const Units& units, const Units& sequence) {
  ASSERT_EQ(sequence.size(), units.size());
  const auto place = [&](const Unit& unit) {
    return std::find_if(sequence.begin(), sequence.end(),
                        [&](const Unit& u) { return u.pass == unit.pass && u.begin == unit.begin; });
  };
  for (std::size_t k = 0; k < units.size(); ++k) {
    ASSERT_NE(place(units[k]), sequence.end());
    for (std::size_t l = 0; l < k; ++l)
      if (touch(units[k], units[l])) {
        ASSERT_LT(place(units[l]), place(units[k]));
      }
  }
}

TEST(ClothSchedule, BandsAndSeamsKeepTheOrderOfThePasses) {
  for (const int rows : {1, 2, 7, 40, 90})
    for (const int bands : {1, 2, 5}) {
      const Units units = some_units(rows, true);
      const Bands cut = cut_into_bands(units, rows, 4, bands);
      for (const auto* parts : {&cut.bands, &cut.seams})
        for (std::size_t i = 0; i < parts->size(); ++i)
          for (std::size_t j = 0; j < i; ++j)
            for (const Unit& a : (*parts)[i])
              for (const Unit& b : (*parts)[j]) ASSERT_FALSE(touch(a, b)) << rows << ' ' << bands;
      Units sequence;
      for (const auto* parts : {&cut.bands, &cut.seams})
        for (const Units& part : *parts) sequence.insert(sequence.end(), part.begin(), part.end());
      expect_in_order(units, sequence);
    }
  EXPECT_GT(cut_into_bands(some_units(90, true), 90, 4, 5).bands.size(), 1u);
}

// Structure, bending and two diagonals down the sheet: beside the best cuts 14 rows wait, so one in sixteen is cut.
TEST(ClothSchedule, SixtyFourBandsFindRoomOnASheetOf1024Rows) {
  const Units units = some_units(1024, true, {1, 2, 0, 0, 1, 1});
  EXPECT_EQ(seam_around(514, units, 1024).height(), 14);
  EXPECT_GT(seam_around(512, units, 1024).height(), 16);
  EXPECT_EQ(cut_into_bands(units, 1024, 4, 64).bands.size(), 64u);
}

TEST(ClothSchedule, StagesKeepTheOrderOfPassesAndIterations) {
  for (const int rows : {1, 2, 7, 40, 90}) {
    const Units units = some_units(rows, false);
    const std::vector<Units> stages = cut_into_stages(units, rows, 8);
    Units sequence;
    for (const Units& stage : stages) sequence.insert(sequence.end(), stage.begin(), stage.end());
    expect_in_order(units, sequence);
    // Bands two apart run at the same time; those of the next iteration that touch a band come later if they are at
    // most one above.
    for (std::size_t i = 0; i < stages.size(); ++i)
      for (std::size_t j = i + 2; j < stages.size(); ++j)
        for (const Unit& a : stages[i])
          for (const Unit& b : stages[j]) ASSERT_FALSE(touch(a, b));
  }
  EXPECT_GT(cut_into_stages(some_units(90, false), 90, 8).size(), 3u);
}

}  // namespace
}  // namespace lockstep::cloth
