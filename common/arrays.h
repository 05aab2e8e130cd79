// The arrays of a state, listed once, and what follows from the list for everyone.
//
// Beside each state stands a function that calls f(name, array, count) for each of its arrays, in a fixed order:
//
//   template <Is<Particles> P, class F>  // Particles<float> or Particles<double>, const or not
//   void for_each_array(P& p, const F& f) {
//     f("id", p.id, p.count);
//     f("position", p.position, p.count);
//   }
//
// An array is an Array or std::vector of numbers or records, or Vectors. Its first `count` elements hold something; the
// rest is padding. Beside each record stands for_each_field(record, f), which calls f(name, value) for each number in
// it that means something: fields that are not there, such as the points beyond a manifold's count, are left out.
//
// From the list follow, in common/: conversion to another precision, and bytes; in verify/arrays.h: hash, comparison by
// name, poison, resume and finiteness.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "common/array.h"
#include "common/vector3.h"

namespace lockstep {

struct SamePrecision;

namespace arrays_detail {
template <class T, template <class> class Template>
inline constexpr bool is_made_of = false;
template <class Real, template <class> class Template>
inline constexpr bool is_made_of<Template<Real>, Template> = true;

// The same type with float and double replaced by To; with SamePrecision, the same type.
template <class T, class To>
struct Rebound {
  using type = T;
};
template <class To>
struct Rebound<float, To> {
  using type = To;
};
template <class To>
struct Rebound<double, To> {
  using type = To;
};
template <template <class> class Template, class T, class To>
struct Rebound<Template<T>, To> {
  using type = Template<typename Rebound<T, To>::type>;
};
template <class T, class To>
struct Rebound<Array<T>, To> {
  using type = Array<typename Rebound<T, To>::type>;
};
template <class T, class To>
struct Rebound<std::vector<T>, To> {
  using type = std::vector<typename Rebound<T, To>::type>;
};
template <class T, class To>
using Rebind =
    typename std::conditional_t<std::is_same_v<To, SamePrecision>, std::type_identity<T>, Rebound<T, To>>::type;
}  // namespace arrays_detail

// Is<Particles> P: P is Particles<float>, const Particles<double>, ...
template <class T, template <class> class Template>
concept Is = arrays_detail::is_made_of<std::remove_const_t<T>, Template>;

// Same<SweepOrder> S: S is SweepOrder or const SweepOrder.
template <class T, class U>
concept Same = std::is_same_v<std::remove_const_t<T>, U>;

// --- Fields of an element: f(field, value), where the field of a plain number is "".

template <class T, class F>
requires std::is_arithmetic_v<T>
void for_each_field(T& x, const F& f) { f("", x); }

template <Is<Vector3> V, class F>
void for_each_field(V& v, const F& f) {
  f("x", v.x), f("y", v.y), f("z", v.z);
}

// Calls f(field, value) for each number of element i.
template <class A, class F>
void for_each_value(A& array, std::size_t i, const F& f) {
  if constexpr (requires { array[i]; })
    for_each_field(array[i], f);
  else  // Vectors
    f("x", array.x[i]), f("y", array.y[i]), f("z", array.z[i]);
}

// --- Two states at a time

// Calls f(name, of_a, count_a, of_b, count_b) for each array of two states whose types differ in precision at the most:
// b is of precision To, or, with SamePrecision, of a's type.
template <class To, class A, class B, class F>
void for_each_array_of_both(A& a, B& b, const F& f) {
  struct Listed {
    const void* array;
    std::size_t count;
  };
  std::vector<Listed> of_b;
  for_each_array(b, [&](const char*, auto& array, std::size_t count) { of_b.push_back({&array, count}); });
  std::size_t k = 0;
  for_each_array(a, [&](const char* name, auto& array, std::size_t count) {
    using Other = arrays_detail::Rebind<std::remove_cvref_t<decltype(array)>, To>;
    using Pointer = std::conditional_t<std::is_const_v<B>, const Other*, Other*>;
    f(name, array, count, *static_cast<Pointer>(const_cast<void*>(of_b[k].array)), of_b[k].count);
    ++k;
  });
}

namespace arrays_detail {
template <class To, class From>
To convert_element(const From& from) {
  if constexpr (std::is_same_v<To, From>) {
    return from;
  } else if constexpr (std::is_arithmetic_v<From>) {
    return static_cast<To>(from);
  } else {
    To to{};
    std::vector<double> values;  // every number, of whatever type, is a double exactly
    for_each_field(from, [&](const char*, auto x) { values.push_back(x); });
    std::size_t k = 0;
    for_each_field(to,
                   [&](const char*, auto& x) { x = static_cast<std::remove_reference_t<decltype(x)>>(values[k++]); });
    return to;
  }
}
template <class From, class To>
void convert_array(const From& from, To& to) {
  to.clear();
  to.reserve(from.size());
  for (const auto& x : from) to.push_back(convert_element<typename To::value_type>(x));
}
template <class T, class U>
void convert_array(const Vectors<T>& from, Vectors<U>& to) {
  convert_array(from.x, to.x), convert_array(from.y, to.y), convert_array(from.z, to.z);
}
}  // namespace arrays_detail

// Copies every array, padding included, into a state of precision To. Widening is exact. What is not an array is left
// alone. Records must list the same fields whatever they hold.
template <class To, class A, class B>
void convert_arrays(const A& from, B& to) {
  for_each_array_of_both<To>(from, to, [](const char*, const auto& a, std::size_t, auto& b, std::size_t) {
    arrays_detail::convert_array(a, b);
  });
}

namespace arrays_detail {
template <class A>
double bytes_of_array(const A& array) {
  if constexpr (requires { array.data(); })
    return static_cast<double>(array.capacity() * sizeof(typename A::value_type));
  else
    return bytes_of_array(array.x) + bytes_of_array(array.y) + bytes_of_array(array.z);
}
}  // namespace arrays_detail

// Bytes that the state's arrays hold.
template <class S>
double bytes_of(const S& state) {
  double bytes = 0;
  for_each_array(state,
                 [&](const char*, const auto& array, std::size_t) { bytes += arrays_detail::bytes_of_array(array); });
  return bytes;
}

}  // namespace lockstep
