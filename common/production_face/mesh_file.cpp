#include "common/production_face/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"
#include "common/production_face/faults.h"
#include "common/words.h"

namespace lockstep::production_face {
namespace {

using Words = std::vector<std::string_view>;

// Bytes of memory that reading may take per byte of a file. A node of 8 bytes takes 24, 40 in the map of its number and
// 4 in the search for doubled ones; a tetrahedron of 8 takes 16, and 20 in the search for its like. A number of a cell
// of 2 takes 8. Of an array that grows there are two, the old one of half the size.
constexpr double bytes_per_byte = 13;

// The words of a file's lines, without those that are blank or a comment.
class Lines {
 public:
  explicit Lines(const std::string& path) : path(path), in(open_input(path)) {
    require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  }

  // The line as it stands; false at the end.
  bool next_line() {
    words.clear();
    if (!std::getline(in, line)) return false;
    ++number;
    words = words_of(line);
    return true;
  }
  // The words of the next line, which last until the one after; none at the end.
  const Words& next() {
    while (next_line() && words.empty()) {
    }
    return words;
  }
  const Words& next(const std::string& expected) {
    if (next().empty()) throw InputError(path + ": ends before " + expected);
    return words;
  }
  // The next word, in this line or a later one.
  std::string_view next_word(const std::string& expected) {
    while (used >= words.size()) {
      next(expected);
      used = 0;
    }
    return words[used++];
  }
  [[noreturn]] void refuse(const std::string& why) const {
    throw InputError(path + ':' + std::to_string(number) + ": " + why);
  }
  // A number of things, or of one of them; refused unless it is whole and not negative.
  std::int64_t whole(const Words& of, std::size_t k, const std::string& what) const {
    const std::optional<std::int64_t> n = k < of.size() ? as<std::int64_t>(of[k]) : std::nullopt;
    if (!n || *n < 0) refuse("expected " + what + ", a whole number");
    return *n;
  }
  std::int64_t whole(std::string_view word, const std::string& what) const { return whole(Words{word}, 0, what); }

 private:
  std::string path;
  std::ifstream in;
  std::string line;
  Words words;
  std::size_t used = 0;
  int number = 0;
};

class Builder {
 public:
  void add_node(const Lines& lines, std::int64_t id, std::span<const std::string_view> coordinates) {
    const std::optional<Vector3<double>> x = as_point(coordinates);
    if (!x || !(std::abs(x->x) <= 1e9 && std::abs(x->y) <= 1e9 && std::abs(x->z) <= 1e9))
      lines.refuse("node: expected three numbers from -1e9 to 1e9, in m");
    if (!number.try_emplace(id, static_cast<std::int32_t>(mesh.nodes.size())).second)
      lines.refuse("node " + std::to_string(id) + " comes twice");
    mesh.nodes.push_back(*x);
  }
  void add_tetrahedron(const Lines& lines, std::span<const std::string_view> corners) {
    if (corners.size() < 4) lines.refuse("tetrahedron: expected four nodes");
    std::array<std::int64_t, 4> ids;
    for (std::size_t a = 0; a < ids.size(); ++a) {
      const std::optional<std::int64_t> id = as<std::int64_t>(corners[a]);
      if (!id) lines.refuse("tetrahedron: " + legible(corners[a]) + " is no node");
      ids[a] = *id;
    }
    add_tetrahedron(lines, ids);
  }
  void add_tetrahedron(const Lines& lines, std::span<const std::int64_t> ids) {
    std::array<std::int32_t, 4> t;
    if (ids.size() < t.size()) lines.refuse("tetrahedron: expected four nodes");
    for (std::size_t a = 0; a < t.size(); ++a) {
      const auto found = number.find(ids[a]);
      if (found == number.end()) lines.refuse("tetrahedron: " + std::to_string(ids[a]) + " is no node");
      t[a] = found->second;
      if (std::find(t.begin(), t.begin() + a, t[a]) != t.begin() + a)
        lines.refuse("tetrahedron: node " + std::to_string(ids[a]) + " comes twice");
    }
    mesh.tetrahedra.push_back(t);
  }
  MeshFile finish(const std::string& path) && { return mended(std::move(mesh), path); }

 private:
  Mesh mesh;
  std::unordered_map<std::int64_t, std::int32_t> number;  // of a node, by the file's number
};

std::string nth(const char* what, std::int64_t i, std::int64_t of) {
  return what + std::string(" ") + std::to_string(i + 1) + " of " + std::to_string(of);
}

void read_nodes(Lines& lines, std::int64_t count, Builder& builder) {
  for (std::int64_t i = 0; i < count; ++i) {
    const Words& words = lines.next(nth("node", i, count));
    const std::int64_t id = lines.whole(words, 0, "the number of a node");
    builder.add_node(lines, id, std::span(words).subspan(1));
  }
}
// Of an element the first words are its own number and, in Gmsh, its tags.
void read_tetrahedra(Lines& lines, std::int64_t count, Builder& builder) {
  for (std::int64_t i = 0; i < count; ++i)
    builder.add_tetrahedron(lines, std::span(lines.next(nth("tetrahedron", i, count))).subspan(1));
}

// --- Formats

MeshFile read_tetgen(const std::string& path) {
  const std::string stem = path.substr(0, path.rfind('.'));
  const bool is_upper = std::isupper(static_cast<unsigned char>(path.back()));
  Builder builder;
  // How many there are, and how many numbers each has.
  const auto read_header = [](Lines& lines, const std::string& what, std::int64_t numbers) {
    const Words& words = lines.next("the number of " + what);
    const std::int64_t count = lines.whole(words, 0, "the number of " + what);
    if (lines.whole(words, 1, "how many numbers each has") != numbers)
      lines.refuse("expected " + what + " of " + std::to_string(numbers) + " numbers");
    return count;
  };
  Lines nodes(stem + (is_upper ? ".NODE" : ".node"));
  read_nodes(nodes, read_header(nodes, "nodes", 3), builder);
  Lines elements(stem + (is_upper ? ".ELE" : ".ele"));
  read_tetrahedra(elements, read_header(elements, "tetrahedra", 4), builder);
  return std::move(builder).finish(path);
}

constexpr int gmsh_tetrahedron = 4;

void read_gmsh_2(Lines& lines, std::string_view section, Builder& builder) {
  const std::int64_t count = lines.whole(lines.next("a number"), 0, "how many there are");
  if (section == "$Nodes") return read_nodes(lines, count, builder);
  for (std::int64_t i = 0; i < count; ++i) {
    const Words& words = lines.next(nth("element", i, count));
    if (lines.whole(words, 1, "the type of an element") != gmsh_tetrahedron) continue;
    const std::size_t tags = lines.whole(words, 2, "the number of its tags");
    builder.add_tetrahedron(lines, std::span(words).subspan(3 + std::min(tags, words.size() - 3)));
  }
}

void read_gmsh_4(Lines& lines, std::string_view section, Builder& builder) {
  const std::int64_t blocks = lines.whole(lines.next("a number"), 0, "the number of blocks");
  for (std::int64_t block = 0; block < blocks; ++block) {
    const Words& header = lines.next(nth("block", block, blocks));
    const std::int64_t count = lines.whole(header, 3, "how many there are in the block");
    const std::int64_t type = lines.whole(header, 2, "the type of its elements");
    if (section == "$Nodes") {
      std::vector<std::int64_t> ids;
      for (std::int64_t i = 0; i < count; ++i)
        ids.push_back(lines.whole(lines.next(nth("node", i, count)), 0, "the number of a node"));
      for (const std::int64_t id : ids) builder.add_node(lines, id, lines.next("the place of a node"));
    } else if (type == gmsh_tetrahedron) {
      read_tetrahedra(lines, count, builder);
    } else {
      for (std::int64_t i = 0; i < count; ++i) lines.next(nth("element", i, count));
    }
  }
}

MeshFile read_gmsh(const std::string& path) {
  Lines lines(path);
  Builder builder;
  if (lines.next("$MeshFormat")[0] != "$MeshFormat") lines.refuse("expected $MeshFormat");
  const Words& format = lines.next("the format");
  const bool is_2 = format[0] == "2.2";
  if ((!is_2 && format[0] != "4.1") || format.size() < 2 || format[1] != "0")
    lines.refuse("expected the format 2.2 or 4.1, and 0 for text");
  for (const char* wanted : {"$Nodes", "$Elements"}) {
    while (lines.next(wanted)[0] != wanted) {
    }
    is_2 ? read_gmsh_2(lines, wanted, builder) : read_gmsh_4(lines, wanted, builder);
    const std::string end = "$End" + std::string(wanted + 1);
    if (lines.next(end)[0] != end) lines.refuse("expected " + end);
  }
  return std::move(builder).finish(path);
}

// The corners of all cells one after another. Those of cell i begin at first[i] and end at first[i + 1].
struct Cells {
  std::vector<std::int64_t> first, corners;

  std::size_t count() const { return first.size() - 1; }
  std::span<const std::int64_t> of(std::size_t i) const {
    return std::span(corners).subspan(first[i], first[i + 1] - first[i]);
  }
};

// Up to version 4 each cell stands after the number of its points; from version 5 on, all after a list of where each
// begins.
Cells read_vtk_cells(Lines& lines) {
  const std::int64_t count = lines.whole(lines.next_word("the number of cells"), "the number of cells");
  const std::int64_t size = lines.whole(lines.next_word("the size of cells"), "the size of cells");
  const auto next_number = [&] { return lines.whole(lines.next_word("the last cell"), "a point"); };
  Cells cells;
  const std::string first(lines.next_word("cells"));
  if (first != "OFFSETS") {
    cells.first = {0};
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t corners = i == 0 ? lines.whole(first, "the number of points of a cell") : next_number();
      for (std::int64_t k = 0; k < corners; ++k) cells.corners.push_back(next_number());
      cells.first.push_back(std::ssize(cells.corners));
    }
    return cells;
  }
  lines.next_word("the type of offsets");
  for (std::int64_t i = 0; i < count; ++i) cells.first.push_back(next_number());
  if (lines.next_word("CONNECTIVITY") != "CONNECTIVITY") lines.refuse("expected CONNECTIVITY");
  lines.next_word("the type of points");
  if (count == 0 || cells.first.back() != size || !std::ranges::is_sorted(cells.first) || cells.first[0] != 0)
    lines.refuse("expected offsets that ascend from 0 to the number of corners");
  for (std::int64_t k = 0; k < size; ++k) cells.corners.push_back(next_number());
  return cells;
}

MeshFile read_vtk(const std::string& path) {
  Lines lines(path);
  Builder builder;
  lines.next_line(), lines.next_line();  // the version and a title
  if (lines.next("ASCII")[0] != "ASCII") lines.refuse("expected ASCII");
  const Words& dataset = lines.next("DATASET");
  if (dataset.size() < 2 || dataset[0] != "DATASET" || dataset[1] != "UNSTRUCTURED_GRID")
    lines.refuse("expected DATASET UNSTRUCTURED_GRID");
  const auto skip_to = [&](const std::string& word) {
    while (lines.next_word(word) != word) {
    }
  };
  skip_to("POINTS");
  const std::int64_t count = lines.whole(lines.next_word("the number of points"), "the number of points");
  lines.next_word("the type of points");
  for (std::int64_t i = 0; i < count; ++i) {
    std::string x[3];
    for (std::string& word : x) word = lines.next_word(nth("point", i, count));
    builder.add_node(lines, i, Words{x[0], x[1], x[2]});
  }
  skip_to("CELLS");
  const Cells cells = read_vtk_cells(lines);
  skip_to("CELL_TYPES");
  if (lines.whole(lines.next_word("the number of types"), "the number of types") != std::int64_t(cells.count()))
    lines.refuse("expected as many types as cells");
  constexpr int vtk_tetrahedron = 10;
  for (std::size_t i = 0; i < cells.count(); ++i)
    if (lines.whole(lines.next_word("the last type"), "the type of a cell") == vtk_tetrahedron)
      builder.add_tetrahedron(lines, cells.of(i));
  return std::move(builder).finish(path);
}

MeshFile read_vega(const std::string& path) {
  Lines lines(path);
  Builder builder;
  while (lines.next("*VERTICES")[0] != "*VERTICES") {
  }
  std::int64_t count = lines.whole(lines.next("the number of nodes"), 0, "the number of nodes");
  read_nodes(lines, count, builder);
  while (lines.next("*ELEMENTS")[0] != "*ELEMENTS") {
  }
  const std::string_view type = lines.next("TET")[0];
  if (type != "TET" && type != "TETS") lines.refuse("expected TET");
  count = lines.whole(lines.next("the number of tetrahedra"), 0, "the number of tetrahedra");
  read_tetrahedra(lines, count, builder);
  return std::move(builder).finish(path);
}

// A function of its own: where g++ 12.2 makes lanes of two such conversions side by side, it drops them.
[[gnu::noinline]] double rounded_to_float(double x) { return static_cast<float>(x); }

}  // namespace

MeshFile mended(Mesh mesh, const std::string& path) {
  for (Vector3<double>& x : mesh.nodes) x = {rounded_to_float(x.x), rounded_to_float(x.y), rounded_to_float(x.z)};
  MeshFile file{std::move(mesh)};
  if (file.mesh.tetrahedra.empty()) throw InputError(path + ": no tetrahedra");
  file.turned = turn_inside_out(file.mesh);
  if (const std::string fault = fault_of(file.mesh); !fault.empty())
    throw InputError(path + ": " + fault + ", counted from 0 in the order of the file");
  file.doubled = count_doubled(file.mesh);
  return file;
}

MeshFile read_mesh(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (extension == ".node" || extension == ".ele") return read_tetgen(path);
  if (extension == ".msh") return read_gmsh(path);
  if (extension == ".vtk") return read_vtk(path);
  if (extension == ".veg") return read_vega(path);
  throw InputError(path + ": expected a file .node, .ele, .msh, .vtk or .veg");
}

}  // namespace lockstep::production_face
