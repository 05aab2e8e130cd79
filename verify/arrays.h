// The verifier's operations on a state's list of arrays (common/arrays.h): hash, comparison, poison, resume,
// finiteness.
#pragma once

#include <cmath>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "common/arrays.h"
#include "verify/compare.h"
#include "verify/run_state.h"

namespace lockstep::verify {

// Names a value for people, from the array, the element and the field: "position.x of particle 12".
using ValueName = std::function<std::string(const std::string& array, std::size_t element, const std::string& field)>;

inline std::string value_name(const std::string& array, std::size_t element, const std::string& field) {
  return array + "[" + std::to_string(element) + "]" + (field.empty() ? "" : "." + field);
}

// ValueName that says "position.x of particle 12".
inline ValueName of_element(const std::string& noun) {
  return [noun](const std::string& array, std::size_t element, const std::string& field) {
    return array + (field.empty() ? "" : "." + field) + " of " + noun + " " + std::to_string(element);
  };
}

// The hash of all values, in order. Padding does not count, so equal results have equal hashes.
template <class S>
std::uint64_t hash_of(const S& state) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](const auto& value) { hash = hash_bytes(std::span(&value, 1), hash); };
  for_each_array(state, [&](const char*, const auto& array, std::size_t count) {
    add(count);
    for (std::size_t i = 0; i < count; ++i)
      for_each_value(array, i, [&](const char*, const auto& value) { add(value); });
  });
  return hash;
}

// Bitwise: asserts that every array has the same number of elements in both states, and every value the same bits.
// Names the first difference with both values, and counts all differences.
template <class S>
void same_bits(Judgement& judgement, const S& openmp, const S& serial, const ValueName& name = value_name) {
  const auto differ = [&](const std::string& what, double a, double b) {
    if (judgement.error == 0) judgement.worst_at = both_values(what, a, b);
    judgement.error += 1;
    judgement.passed = false;
  };
  struct Value {
    const char* field;
    double value;
    std::uint64_t bits;
  };
  const auto values_of = [](const auto& array, std::size_t i, std::vector<Value>& values) {
    values.clear();
    for_each_value(array, i, [&](const char* field, const auto& x) {
      Value value = {field, static_cast<double>(x), 0};
      std::memcpy(&value.bits, &x, sizeof x);
      values.push_back(value);
    });
  };
  std::vector<Value> a, b;
  // Both states have one type, so corresponding arrays have one type too.
  for_each_array_of_both<SamePrecision>(
      openmp, serial, [&](const char* array, const auto& o, std::size_t o_count, const auto& s, std::size_t s_count) {
        if (o_count != s_count) return differ("size of " + std::string(array), double(o_count), double(s_count));
        if constexpr (requires { o.data(); })
          if (s_count == 0 || std::memcmp(o.data(), s.data(), s_count * sizeof(o[0])) == 0) return;
        for (std::size_t i = 0; i < s_count; ++i) {
          values_of(o, i, a), values_of(s, i, b);
          for (std::size_t k = 0; k < a.size() && k < b.size(); ++k)
            if (a[k].bits != b[k].bits) differ(name(array, i, b[k].field), a[k].value, b[k].value);
          if (a.size() != b.size())
            differ("number of fields of " + name(array, i, ""), double(a.size()), double(b.size()));
        }
      });
}

// The judgement of twins that must leave the same bits.
template <class S>
Judgement bitwise(const S& openmp, const S& serial, const ValueName& name = value_name) {
  Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(judgement, openmp, serial, name);
  return judgement;
}

// Sets every bit of the arrays, which makes floats NaN and integers -1. A kernel that leaves a result unwritten then
// fails instead of passing by luck.
template <class S>
void poison(S& state) {
  const auto fill = [](auto& array) {
    std::memset(static_cast<void*>(array.data()), 0xff, array.size() * sizeof(array[0]));
  };
  for_each_array(state, [&](const char*, auto& array, std::size_t) {
    if constexpr (requires { array.data(); })
      fill(array);
    else
      fill(array.x), fill(array.y), fill(array.z);
  });
}

// The arrays that a run must save to resume from this state. The state must outlive the result.
template <class S>
std::vector<Kept> keep_all(S& state) {
  std::vector<Kept> kept;
  for_each_array(state, [&](const char*, auto& array, std::size_t) {
    if constexpr (requires { array.data(); })
      kept.push_back(keep(array));
    else
      kept.insert(kept.end(), {keep(array.x), keep(array.y), keep(array.z)});
  });
  return kept;
}

// The name of the first value that is infinite or NaN; "" if all are finite.
template <class S>
std::string first_not_finite(const S& state, const ValueName& name = value_name) {
  std::string first;
  for_each_array(state, [&](const char* array_name, const auto& array, std::size_t count) {
    for (std::size_t i = 0; i < count && first.empty(); ++i)
      for_each_value(array, i, [&](const char* field, const auto& x) {
        if constexpr (std::is_floating_point_v<std::remove_cvref_t<decltype(x)>>)
          if (!std::isfinite(x) && first.empty()) first = name(array_name, i, field) + " is not finite";
      });
  });
  return first;
}

}  // namespace lockstep::verify
