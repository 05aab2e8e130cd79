// common/production_face/mesh_file.h: the same mesh in every format, and files that are refused, in one line that says
// where.
#include "common/production_face/mesh_file.h"

#include <gtest/gtest.h>

#include <functional>
#include <sstream>

#include "common/production_face/faults.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_face {
namespace {

// Two cells: 24 tetrahedra, with coordinates that text holds exactly.
Mesh small() { return make_lattice({2, 1, 1}, .25); }

std::string place(const Vector3<double>& x) {
  std::ostringstream out;
  out << x.x << ' ' << x.y << ' ' << x.z << '\n';
  return out.str();
}
std::string corners(const std::array<std::int32_t, 4>& t, int base) {
  std::string text;
  for (const std::int32_t n : t) text += ' ' + std::to_string(n + base);
  return text + '\n';
}

std::string nodes(const Mesh& mesh, int base) {
  std::string text;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) text += std::to_string(n + base) + ' ' + place(mesh.nodes[n]);
  return text;
}
std::string elements(const Mesh& mesh, int base, const std::string& tags = "") {
  std::string text;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    text += std::to_string(t + 1) + tags + corners(mesh.tetrahedra[t], base);
  return text;
}
std::string count(const auto& all) { return std::to_string(all.size()); }

std::string node(const Mesh& mesh, int base) {
  return "# Generated\n\n" + count(mesh.nodes) + " 3 0 0\n" + nodes(mesh, base) + "# end\n";
}
std::string ele(const Mesh& mesh, int base) { return count(mesh.tetrahedra) + " 4 0\n" + elements(mesh, base); }

std::string msh_2(const Mesh& mesh) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"flesh\"\n$EndPhysicalNames\n$Nodes\n" +
         count(mesh.nodes) + '\n' + nodes(mesh, 10) + "$EndNodes\n$Elements\n" +
         std::to_string(mesh.tetrahedra.size() + 1) + "\n1 2 2 0 1 10 11 13\n" + elements(mesh, 10, " 4 2 0 1") +
         "$EndElements\n";
}
std::string msh_4(const Mesh& mesh) {
  const std::size_t half = mesh.nodes.size() / 2;  // in two blocks
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n$EndEntities\n$Nodes\n2 " +
                     count(mesh.nodes) + " 7 99\n";
  for (int block = 0; block < 2; ++block) {
    const std::size_t from = block * half, to = block ? mesh.nodes.size() : half;
    text += "3 1 0 " + std::to_string(to - from) + '\n';
    for (std::size_t n = from; n < to; ++n) text += std::to_string(n + 7) + '\n';
    for (std::size_t n = from; n < to; ++n) text += place(mesh.nodes[n]);
  }
  return text + "$EndNodes\n$Elements\n2 0 1 99\n2 1 2 1\n1 7 8 10\n3 1 4 " + count(mesh.tetrahedra) + '\n' +
         elements(mesh, 7) + "$EndElements\n";
}
std::string vtk_head(const Mesh& mesh, const std::string& version) {
  std::string text = "# vtk DataFile Version " + version + "\nPOINTS and CELLS # a title\nASCII\n" +
                     "DATASET UNSTRUCTURED_GRID\nPOINTS " + count(mesh.nodes) + " double\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    text += place(mesh.nodes[n]);
    if (n % 2) text.back() = ' ';  // points share lines
  }
  return text + "\nMETADATA\nINFORMATION 0\n\n";
}
std::string vtk_types(std::size_t tetrahedra) {
  std::string text = "CELL_TYPES " + std::to_string(tetrahedra + 1) + "\n5\n";
  for (std::size_t t = 0; t < tetrahedra; ++t) text += "10\n";
  return text;
}
std::string vtk_3(const Mesh& mesh) {
  const std::size_t n = mesh.tetrahedra.size();
  std::string text = vtk_head(mesh, "3.0") + "CELLS " + std::to_string(n + 1) + ' ' + std::to_string(5 * n + 4) + '\n';
  text += "3 0 1 3\n";  // a triangle
  for (const auto& t : mesh.tetrahedra) text += '4' + corners(t, 0);
  return text + vtk_types(n);
}
std::string vtk_5(const Mesh& mesh) {
  const std::size_t n = mesh.tetrahedra.size();
  std::string text = vtk_head(mesh, "5.1") + "CELLS " + std::to_string(n + 2) + ' ' + std::to_string(4 * n + 3) + '\n';
  text += "OFFSETS vtktypeint64\n0 ";
  for (std::size_t t = 0; t <= n; ++t) text += std::to_string(4 * t + 3) + ' ';
  text += "\nCONNECTIVITY vtktypeint64\n0 1 3\n";
  for (const auto& t : mesh.tetrahedra) text += corners(t, 0);
  return text + vtk_types(n);
}
std::string veg(const Mesh& mesh) {
  return "# Vega\n*VERTICES\n" + count(mesh.nodes) + " 3 0 0\n" + nodes(mesh, 1) + "*ELEMENTS\nTET\n" +
         count(mesh.tetrahedra) + " 4 0\n" + elements(mesh, 1) + "*MATERIAL flesh\nENU, 1000, 1e6, 0.45\n";
}

struct ProductionFaceMeshFile : TemporaryFolder {
  // What reading says, with the folder left out.
  std::string error(const std::string& name, const std::string& bytes) {
    write_bytes(path(name), bytes);
    std::string message = error_of([&] { read_mesh(path(name)); });
    for (std::size_t at; (at = message.find(folder + '/')) != message.npos;) message.erase(at, folder.size() + 1);
    return message;
  }
};

TEST_F(ProductionFaceMeshFile, EveryFormatHoldsTheSameMesh) {
  const Mesh mesh = small();
  const std::pair<std::string, std::string> files[] = {
      {"a.msh", msh_2(mesh)}, {"b.MSH", msh_4(mesh)},    {"a.vtk", vtk_3(mesh)}, {"b.vtk", vtk_5(mesh)},
      {"a.veg", veg(mesh)},   {"a.node", node(mesh, 1)}, {"a.ele", ele(mesh, 1)}};
  for (const auto& file : files) write_bytes(path(file.first), file.second);
  write_bytes(path("zero.node"), node(mesh, 0)), write_bytes(path("zero.ele"), ele(mesh, 0));
  for (const char* name : {"a.msh", "b.MSH", "a.vtk", "b.vtk", "a.veg", "a.node", "a.ele", "zero.ele"}) {
    SCOPED_TRACE(name);
    const MeshFile read = read_mesh(path(name));
    EXPECT_EQ(read.turned, 0);
    EXPECT_EQ(read.mesh.tetrahedra, mesh.tetrahedra);
    ASSERT_EQ(read.mesh.nodes.size(), mesh.nodes.size());
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      EXPECT_EQ(read.mesh.nodes[n].x, mesh.nodes[n].x);
      EXPECT_EQ(read.mesh.nodes[n].y, mesh.nodes[n].y);
      EXPECT_EQ(read.mesh.nodes[n].z, mesh.nodes[n].z);
    }
  }
}

TEST_F(ProductionFaceMeshFile, NegativeVolumesAreTurned) {
  Mesh mesh = small();
  for (const int t : {2, 7, 11}) std::swap(mesh.tetrahedra[t][0], mesh.tetrahedra[t][1]);
  write_bytes(path("a.veg"), veg(mesh));
  const MeshFile read = read_mesh(path("a.veg"));
  EXPECT_EQ(read.turned, 3);
  EXPECT_EQ(fault_of(read.mesh), "");
}

// Two cells with a cut between them: each has its own four nodes of the common face. As one mesh they have four less.
TEST_F(ProductionFaceMeshFile, NodesAtOnePlaceAreTheSidesOfACut) {
  Mesh mesh = make_lattice({1, 1, 1}, .25);
  const int nodes = static_cast<int>(mesh.nodes.size());
  for (int n = 0; n < nodes; ++n) mesh.nodes.push_back(mesh.nodes[n] + Vector3<double>{.25, 0, 0});
  for (std::size_t t = 0; t < 12; ++t) {
    mesh.tetrahedra.push_back(mesh.tetrahedra[t]);
    for (std::int32_t& corner : mesh.tetrahedra.back()) corner += nodes;
  }
  write_bytes(path("a.veg"), veg(mesh));
  const MeshFile read = read_mesh(path("a.veg"));
  EXPECT_EQ(read.doubled, 4);
  EXPECT_EQ(read.mesh.nodes.size(), 18u);
}

// A body's places are float: half a metre apart at 2^22 m, eight metres at 2^26.
TEST_F(ProductionFaceMeshFile, WhatFloatMakesFlatIsRefused) {
  const auto from = [&](double away) {
    Mesh mesh = make_lattice({1, 1, 1}, 1);
    for (Vector3<double>& x : mesh.nodes) x.x += away;
    std::ostringstream text;
    text.precision(17);
    text << "*VERTICES\n9 3\n";
    for (std::size_t n = 0; n < 9; ++n)
      text << n << ' ' << mesh.nodes[n].x << ' ' << mesh.nodes[n].y << ' ' << mesh.nodes[n].z << '\n';
    return text.str() + "*ELEMENTS\nTET\n12 4\n" + elements(mesh, 0);
  };
  write_bytes(path("a.veg"), from(1 << 22));
  EXPECT_EQ(read_mesh(path("a.veg")).turned, 0);
  EXPECT_EQ(error("a.veg", from(1 << 26)),
            "a.veg: tetrahedron 0 has no positive volume, counted from 0 in the order of the file");
}

// Wherever a file ends, short of its last few words, it is refused in a line that begins with its name.
TEST_F(ProductionFaceMeshFile, CutShortIsRefused) {
  const Mesh mesh = make_lattice({1, 1, 1}, .25);
  const std::string vega = veg(mesh).substr(0, veg(mesh).find("*MATERIAL"));
  write_bytes(path("n.node"), node(mesh, 1));
  const std::pair<std::string, std::string> files[] = {{"a.msh", msh_2(mesh)}, {"b.msh", msh_4(mesh)},
                                                       {"a.vtk", vtk_3(mesh)}, {"b.vtk", vtk_5(mesh)},
                                                       {"a.veg", vega},        {"n.ele", ele(mesh, 1)}};
  for (const auto& file : files)
    for (std::size_t size = 0; size + 4 < file.second.size(); ++size) {
      const std::string message = error(file.first, file.second.substr(0, size));
      EXPECT_TRUE(message.starts_with(file.first + ':')) << size << ' ' << message;
    }
}

TEST_F(ProductionFaceMeshFile, SaysWhatIsWrong) {
  const Mesh mesh = make_lattice({1, 1, 1}, .25);
  const auto changed = [&](const std::function<void(Mesh&)>& change) {
    Mesh copy = mesh;
    change(copy);
    return veg(copy);
  };
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    EXPECT_NE(text.find(from), text.npos) << from;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(error("a.off", "OFF\n"), "a.off: expected a file .node, .ele, .msh, .vtk or .veg");
  EXPECT_EQ(error("alone.ele", ele(mesh, 1)), "alone.node: cannot be read: No such file or directory");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) { m.tetrahedra[1][2] = 40; })), "a.veg:17: tetrahedron: 41 is no node");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) {
                    m.tetrahedra[1] = {0, 3, 8, 3};
                  })),
            "a.veg:17: tetrahedron: node 4 comes twice");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) {
                    m.tetrahedra[1] = {0, 1, 2, 3};
                  })),
            "a.veg: tetrahedron 1 has no positive volume, counted from 0 in the order of the file");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) {
                    m.nodes.push_back({1, 1, 1});
                  })),
            "a.veg: node 9 is in no tetrahedron, counted from 0 in the order of the file");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) { m.tetrahedra.push_back(m.tetrahedra[7]); })),
            "a.veg: tetrahedron 12 has the nodes of tetrahedron 7, counted from 0 in the order of the file");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) { m.nodes[8].x = 2.5e-5; })),
            "a.veg: tetrahedron 0 is a sliver: its volume is less than 1e-4 of its longest edge cubed, counted from 0 "
            "in the order of the file");
  EXPECT_EQ(error("a.veg", changed([](Mesh& m) { m.tetrahedra.clear(); })), "a.veg: no tetrahedra");
  for (const char* bad : {"nan", "inf", "-1e300", "x"})
    EXPECT_EQ(error("a.veg", replaced(veg(mesh), "0.125 0.125 0.125", std::string("0 0 ") + bad)),
              "a.veg:12: node: expected three numbers from -1e9 to 1e9, in m");
  EXPECT_EQ(error("a.veg", replaced(veg(mesh), "\n2 0.25", "\n1 0.25")), "a.veg:5: node 1 comes twice");
  EXPECT_EQ(error("a.veg", replaced(veg(mesh), "TET", "CUBIC")), "a.veg:14: expected TET");
  EXPECT_EQ(error("a.veg", "*VERTICES\n-3 3 0 0\n"), "a.veg:2: expected the number of nodes, a whole number");
  EXPECT_EQ(error("a.veg", "*VERTICES\n9000000000000000000 3 0 0\n1 0 0 0\n"),
            "a.veg: ends before node 2 of 9000000000000000000");
  EXPECT_EQ(error("a.msh", "x\n"), "a.msh:1: expected $MeshFormat");
  EXPECT_EQ(error("a.msh", replaced(msh_2(mesh), "2.2 0", "2.2 1")),
            "a.msh:2: expected the format 2.2 or 4.1, and 0 for text");
  EXPECT_EQ(error("a.msh", replaced(msh_4(mesh), "4.1 0", "4 0")),
            "a.msh:2: expected the format 2.2 or 4.1, and 0 for text");
  EXPECT_EQ(error("a.msh", replaced(msh_2(mesh), "4 2 0 1 ", "4 9000000000000000000 0 1 ")),
            "a.msh:23: tetrahedron: expected four nodes");
  EXPECT_EQ(error("a.vtk", replaced(vtk_3(mesh), "ASCII", "BINARY")), "a.vtk:3: expected ASCII");
  EXPECT_EQ(error("a.vtk", replaced(vtk_3(mesh), "UNSTRUCTURED_GRID", "POLYDATA")),
            "a.vtk:4: expected DATASET UNSTRUCTURED_GRID");
  EXPECT_EQ(error("a.vtk", replaced(vtk_5(mesh), "0 3 7", "0 8 7")).substr(8),
            ": expected offsets that ascend from 0 to the number of corners");
  EXPECT_EQ(error("a.node", replaced(node(mesh, 1), " 3 0 0", " 2 0 0")), "a.node:3: expected nodes of 3 numbers");
  EXPECT_EQ(error("b.ele", ""), "b.node: cannot be read: No such file or directory");
}

}  // namespace
}  // namespace lockstep::production_face
