// PLY: a header of lines that names elements and the properties of each, then the elements, in text or in binary.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/polygons.h"
#include "common/words.h"

namespace lockstep {
namespace {

// A type of numbers, in the order of its names below.
enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

std::optional<Type> type_of(std::string_view name) {
  constexpr std::array<std::string_view, 8> old = {"char", "uchar", "short", "ushort",
                                                   "int",  "uint",  "float", "double"};
  constexpr std::array<std::string_view, 8> sized = {"int8",  "uint8",  "int16",   "uint16",
                                                     "int32", "uint32", "float32", "float64"};
  for (const auto& names : {old, sized})
    if (const auto found = std::ranges::find(names, name); found != names.end())
      return static_cast<Type>(found - names.begin());
  return std::nullopt;
}

struct Property {
  std::string name;
  Type type;
  std::optional<Type> count;  // of a list
};

struct Element {
  std::string name;
  std::int64_t count;
  std::vector<Property> properties;
};

enum class Format { text, little_endian, big_endian };

struct Header {
  Format format;
  std::vector<Element> elements;
};

Header read_header(std::ifstream& in, const std::string& path) {
  int number = 0;
  const auto refuse = [&](const std::string& message) {
    throw InputError(path + ':' + std::to_string(number) + ": " + message);
  };
  std::optional<Format> format;
  std::vector<Element> elements;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::vector<std::string_view> words = words_of(line);
    if (number == 1) {
      if (words.size() != 1 || words[0] != "ply") refuse("expected ply");
    } else if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      continue;
    } else if (words[0] == "format" && words.size() == 3) {
      constexpr std::array<std::string_view, 3> names = {"ascii", "binary_little_endian", "binary_big_endian"};
      const auto found = std::ranges::find(names, words[1]);
      if (found == names.end()) refuse("expected the format ascii, binary_little_endian or binary_big_endian");
      format = static_cast<Format>(found - names.begin());
    } else if (words[0] == "element" && words.size() == 3) {
      const std::int64_t count = as<std::int64_t>(words[2]).value_or(-1);
      if (count < 0) refuse("expected a name and a number of elements");
      elements.push_back({std::string(words[1]), count, {}});
    } else if (words[0] == "property" && (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
      const bool is_list = words.size() == 5;
      const std::optional<Type> count = is_list ? type_of(words[2]) : std::nullopt,
                                type = type_of(words[words.size() - 2]);
      if (elements.empty() || !type || (is_list && !count))
        refuse("expected the property of an element: a type, or list and two types, and a name");
      elements.back().properties.push_back({std::string(words.back()), *type, count});
    } else if (words[0] == "end_header") {
      if (!format) refuse("expected a format before the header ends");
      for (const Element& element : elements)
        if (element.properties.empty()) refuse("expected a property of each element");
      return {*format, elements};
    } else {
      refuse("expected format, element, property, comment or end_header, not " + legible(words[0]));
    }
  }
  throw InputError(path + ": ends within its header");
}

// The numbers behind the header.
class Numbers {
 public:
  Numbers(std::ifstream& in, Format format) : in_(in), format_(format) {}

  // NaN where there is none; ended() then says whether the file was at its end.
  double next(Type type) {
    switch (format_ == Format::text ? Type::f64 : type) {
      case Type::i8: return binary<std::int8_t>();
      case Type::u8: return binary<std::uint8_t>();
      case Type::i16: return binary<std::int16_t>();
      case Type::u16: return binary<std::uint16_t>();
      case Type::i32: return binary<std::int32_t>();
      case Type::u32: return binary<std::uint32_t>();
      case Type::f32: return binary<float>();
      case Type::f64: return format_ == Format::text ? word() : binary<double>();
    }
    return nan;
  }

  bool ended() const { return !in_; }

 private:
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

  double word() {
    std::string word;
    in_ >> word;
    return as<double>(word).value_or(nan);
  }

  template <class Number>
  double binary() {
    std::array<char, sizeof(Number)> bytes;
    if (!in_.read(bytes.data(), bytes.size())) return nan;
    if (format_ == Format::big_endian) std::ranges::reverse(bytes);
    return std::bit_cast<Number>(bytes);
  }

  std::ifstream& in_;
  Format format_;
};

}  // namespace

Mesh read_ply(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(mesh_bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  const Header header = read_header(in, path);
  Numbers numbers(in, header.format);
  Polygons polygons(path, [&](int number, bool is_face) {
    return path + (is_face ? ": face " : ": vertex ") + std::to_string(number);
  });
  for (const Element& element : header.elements) {
    const std::string& name = element.name;
    const bool is_vertex = name == "vertex", is_face = name == "face";
    for (std::int64_t i = 1; i <= element.count; ++i) {
      const auto refuse = [&](const std::string& message) {
        throw InputError(path + ": " + legible(name) + ' ' + std::to_string(i) + ": " + message);
      };
      Vector3<double> point = {NAN, NAN, NAN};
      std::vector<std::int64_t> face;
      for (const Property& property : element.properties) {
        const bool is_corners = is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
        const double length = property.count ? numbers.next(*property.count) : 1;
        if (!numbers.ended() && !(length >= 0 && length == std::floor(length)))
          refuse("expected how many numbers there are in a list");
        for (double k = 0; k < length && !numbers.ended(); ++k) {
          const double x = numbers.next(property.type);
          if (is_vertex && property.name == "x") point.x = x;
          if (is_vertex && property.name == "y") point.y = x;
          if (is_vertex && property.name == "z") point.z = x;
          if (!is_corners || numbers.ended()) continue;
          if (!(x >= 0 && x < 1e9 && x == std::floor(x))) refuse("expected the numbers of its points, from 0");
          face.push_back(static_cast<std::int64_t>(x) + 1);
        }
      }
      if (numbers.ended()) refuse("the file ends before it does");
      if (is_vertex) polygons.add_point(static_cast<int>(i), point);
      if (is_face) polygons.add_face(static_cast<int>(i), face);
    }
  }
  return std::move(polygons).mesh();
}

}  // namespace lockstep
