// facesim's files, which the tests write by their description: the same face, muscles, bones and frames as those that
// they were made of, and files that are refused in one line that names them.
#include "common/production_face/facesim.h"

#include <cmath>
#include <functional>
#include <limits>

#include "common/convert.h"
#include "common/memory.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"
#include "tests/facesim_files.h"
#include "tests/production_face_matrices.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_face {
namespace {

// The rotation by the length of a vector about its direction.
Matrix turned(const Vector& turn) {
  const double angle = std::sqrt(dot(turn, turn));
  const Vector axis = angle > 0 ? (1 / angle) * turn : Vector{1, 0, 0};
  const auto column = [&](const Vector& x) {
    return std::cos(angle) * x + std::sin(angle) * cross(axis, x) + (1 - std::cos(angle)) * dot(axis, x) * axis;
  };
  return {column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})};
}

std::vector<Vector> columns(const Matrix& m, const Vector& shift) { return {m.x, m.y, m.z, shift}; }

struct ProductionFaceFacesim : TemporaryFolder {
  Scene load(const FacesimFiles& files, const std::string& more = "", const std::string& keys = "") const {
    std::filesystem::remove_all(path("face"));
    write_facesim(path("face"), files);
    write_bytes(path("a.toml"), "kind = \"production_face\"\n" + more + "[facesim]\nfolder = \"face\"\n" + keys);
    return load_scene(path("a.toml"));
  }
  // What loading says, with the folder left out.
  std::string error(const FacesimFiles& files, const std::string& keys = "controls = \"face\"\n") const {
    std::string message = error_of([&] { load(files, "", keys); });
    for (std::size_t at; (at = message.find(folder + '/')) != message.npos;) message.erase(at, folder.size() + 1);
    return message;
  }
};

// Directions and shares are float in the files, so a fibre may be off by an ulp; all else has the same bits.
TEST_F(ProductionFaceFacesim, AFaceIsTheOneItWasWrittenFrom) {
  const FaceMesh face = make_face_mesh(.0115);
  const std::string keys = "[[key]]\ntime = 0.5\n[[key.pull]]\nmuscle = \"risorius_left\"\nactivation = 0.5\n"
                           "[[key.move]]\nbone = \"jaw\"\nturn = [0.1, 0, 0]\n";
  const Scene read = load(facesim_files(face, jaw_joint), "", keys);
  write_bytes(path("b.toml"), "kind = \"production_face\"\n[face]\nspacing = 0.0115\n[[key]]\ntime = 0.5\n"
                              "[[key.pull]]\nmuscle = \"risorius left\"\nactivation = 0.5\n"
                              "[[key.move]]\nbone = \"jaw\"\nturn = [0.1, 0, 0]\n");
  const Scene made = load_scene(path("b.toml"));
  EXPECT_EQ(read.turned + read.doubled, 0);
  EXPECT_EQ(read.body.corner.value, made.body.corner.value);
  EXPECT_EQ(read.body.gradient.value, made.body.gradient.value);
  EXPECT_EQ(read.body.volume.value, made.body.volume.value);
  EXPECT_EQ(read.body.first_fibre, made.body.first_fibre);
  EXPECT_EQ(read.body.muscle.value, made.body.muscle.value);
  EXPECT_EQ(read.body.held, made.body.held);
  EXPECT_EQ(read.motion.bone_of_held, made.motion.bone_of_held);
  ASSERT_EQ(read.body.fibre.value.size(), made.body.fibre.value.size());
  for (std::size_t i = 0; i < made.body.fibre.value.size(); ++i)
    EXPECT_NEAR(read.body.fibre.value[i], made.body.fibre.value[i], 0x1p-23);
  ASSERT_EQ(read.pose.activation, made.pose.activation);
  const Target<float> now = target_at(read.body, read.motion, .3), expected = target_at(made.body, made.motion, .3);
  EXPECT_EQ(now.activation, expected.activation);
  for (std::size_t k = 0; k < expected.held.x.size(); ++k) {
    // The joint is float in the file, so that the jaw, turned by less than .1 rad, is shifted by .1 times its rounding.
    const Vector must = convert<double>(lockstep::load(expected.held, k));
    const Vector off = convert<double>(lockstep::load(now.held, k)) - must;
    EXPECT_LE(std::sqrt(dot(off, off)),
              0x1p-24 * (.1 * std::sqrt(dot(jaw_joint, jaw_joint)) + 2 * std::sqrt(dot(must, must))));
  }
}

// Frames are 1/24 s apart: the cranium's nodes go where the file says, and the jaw's where the cranium brings what the
// file says. The bound: a rotation of float columns is off by up to sqrt(3) u, its nearest rotation by twice that; two
// of them turn points at up to .0173 m; shifts of .0396 m and displacements of up to .075 m are rounded.
TEST_F(ProductionFaceFacesim, FramesAreThoseOfTheControls) {
  FacesimFiles files = small_facesim_files();
  const Vector turns[] = {{.1, -.2, .3}, {-3.14155, 0, 0}, {0, 2.2, -2.2}, {1e-3, 0, 0}, {0, 0, 0}};
  int frame = 0;
  for (const Vector& turn : turns) {
    const Matrix cranium = turned(turn), jaw = turned({.19, .01, 0});
    const Vector shift = {.01, -.02, .03}, slide = {0, .001, .002};
    files["storytelling_controls." + std::to_string(++frame)] =
        controls_of({{.25, .75}, columns(cranium, shift), columns(jaw, slide)});
    const Scene scene = load(files, "frames = 5\n", "controls = \"face\"\n");
    ASSERT_EQ(scene.motion.keys.size(), frame + 1u);
    EXPECT_EQ(scene.pose.activation, (Array<float>{0, 1}));
    const Target<float> target = target_at(scene.body, scene.motion, frame * frame_time);
    EXPECT_EQ(target.activation, (Array<float>{.25f, .75f}));
    ASSERT_EQ(scene.body.held, (Array<std::int32_t>{0, 1, 6, 7}));
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector x = convert<double>(lockstep::load(scene.body.rest, scene.body.held[k]));
      const Vector to = cranium * (k < 2 ? x : jaw * x + slide) + shift;
      const Vector d = convert<double>(lockstep::load(target.held, k));
      const Vector off = x + d - to;
      EXPECT_LE(std::sqrt(dot(off, off)), .235 * 0x1p-24) << frame << ' ' << k;
    }
  }
}

// As in the program: nodes of attachments by their places, the last of two attachments, a muscle's own stress.
TEST_F(ProductionFaceFacesim, PartitionedFilesAndListsAreRead) {
  FacesimFiles files = small_facesim_files();
  files["peak_isometric_stress_list.txt"] = "2\nb 1.5e5 nobody 7\n";
  files["jaw.attached_nodes"] = nodes_from_one({1, 6, 7});
  const Scene alone = load(files);
  EXPECT_EQ(alone.body.held, (Array<std::int32_t>{0, 1, 6, 7}));
  EXPECT_EQ(alone.motion.bone_of_held, (Array<std::int32_t>{0, 1, 1, 1}));
  std::vector<float> stress;
  for (int slot = 0; slot < alone.body.fibre.blocks() * lanes; ++slot)
    if (alone.body.muscle.at(slot, 0) >= 0) stress.push_back(alone.body.fibre.at(slot, 4));
  EXPECT_EQ(stress, (std::vector<float>{3e5f, 3e5f, 1.5e5f}));
  auto tet = files.extract("face_simulation.tet");
  files["face_simulation_1.tet"] = tet.mapped();
  files["particle_positions_1.dat"] = nodes_from_one({8, 7, 6, 5, 4, 3, 2, 1, 0});
  EXPECT_EQ(load(files).body.held, (Array<std::int32_t>{1, 2, 7, 8}));
}

// Greatest tension scales both curves: half of it halves what fibres add to the stress.
TEST_F(ProductionFaceFacesim, AMusclesOwnStressScalesItsPull) {
  const Mesh mesh = make_lattice({1, 1, 1}, .01);
  const auto stress = [&](double of_muscle, float activation) {
    const Body<float> body = make_body(mesh, {{5, 0, {1, 0, 0}, .5, of_muscle}}, 1);
    Pose<float> pose;
    pose.displacement.resize(body.nodes), pose.activation = {activation};
    for (int n = 0; n < body.nodes; ++n) pose.displacement.x[n] = .125f * body.rest.x[n];
    Strained<float> strained = make_strained(body);
    serial::update_state(body, {}, pose, false, strained);
    return strained.stress.at(5, 0);
  };
  for (const float activation : {0.f, 1.f}) {
    const double none = stress(0, activation), half = stress(1.5e5, activation), whole = stress(3e5, activation);
    EXPECT_GT(whole - none, 1000);
    EXPECT_NEAR(whole - none, 2 * (half - none), 4 * 0x1p-24 * whole);
  }
}

// Wherever a file ends, it is refused in a line that begins with a file of the folder; and so is one that goes on.
TEST_F(ProductionFaceFacesim, CutShortOrTooLongIsRefused) {
  const FacesimFiles good = small_facesim_files();
  EXPECT_EQ(error(good), "no error");
  for (const auto& file : good) {
    const bool is_text = file.first.ends_with(".txt");
    const auto expect_refused = [&](const std::string& bytes) {
      FacesimFiles files = good;
      files[file.first] = bytes;
      const std::string message = error(files);
      EXPECT_TRUE(message.starts_with("face/")) << file.first << ' ' << bytes.size() << ' ' << message;
      if (!is_text) {
        EXPECT_TRUE(message.starts_with("face/" + file.first + ": ")) << message;
      }
    };
    const bool is_empty = file.second == "0\n";  // of which one byte is as good
    for (std::size_t size = 0; size + (is_text) < file.second.size(); ++size)
      if (!is_empty || size == 0) expect_refused(file.second.substr(0, size));
    if (!is_text) expect_refused(file.second + '\0');
    FacesimFiles files = good;
    files.erase(file.first);
    EXPECT_NE(error(files).find(": cannot be read: No such file or directory"), std::string::npos) << file.first;
  }
}

TEST_F(ProductionFaceFacesim, SaysWhatIsWrong) {
  const FacesimFiles good = small_facesim_files();
  const auto with = [&](const std::string& name, const std::string& bytes) {
    FacesimFiles files = good;
    files[name] = bytes;
    return error(files);
  };
  const auto replaced = [&](const std::string& name, std::size_t at, const std::string& bytes) {
    std::string text = good.at(name);
    return with(name, text.replace(at, bytes.size(), bytes));
  };
  const std::string tet = "face_simulation.tet", muscle = "b.constitutive_data", frame = "storytelling_controls.0";
  EXPECT_EQ(replaced(tet, 4, whole(3)), "face/" + tet + ": corners of a tetrahedron: 3, expected 4");
  EXPECT_EQ(replaced(tet, 8, whole(2000000000)),
            "face/" + tet + ": 2000000000 tetrahedra, for which 320 bytes are left");
  EXPECT_EQ(replaced(tet, 8, whole(-1)), "face/" + tet + ": -1 tetrahedra, for which 320 bytes are left");
  EXPECT_EQ(replaced(tet, 0, whole(2000000000)),
            "face/" + tet + ": the number of particles: 9, expected 2000000000");
  EXPECT_EQ(replaced(tet, 12, whole(0)),
            "face/" + tet + ": a corner of tetrahedron 1: 0, expected one from 1 to 9");
  EXPECT_EQ(replaced(tet, 12 + 12 * 16, std::string(1, '\0')),
            "face/" + tet + ": the byte after tetrahedra: expected 1");
  EXPECT_EQ(replaced(tet, 12 + 12 * 16 + 1 + 12 + 3 + 4, number(std::numeric_limits<double>::quiet_NaN())),
            "face/" + tet + ": the place of node 1: expected a number from -1e9 to 1e9");
  EXPECT_EQ(replaced(tet, 16, whole(9)).substr(0, 43), "face/face_simulation.tet: tetrahedron 0 has");
  EXPECT_EQ(replaced(muscle, 4, whole(13)), "face/" + muscle + ": tetrahedron 1: 13, expected one from 1 to 12");
  EXPECT_EQ(replaced("a.constitutive_data", 8, whole(1)),
            "face/a.constitutive_data: tetrahedron 1 comes twice");
  EXPECT_EQ(replaced(muscle, 8, whole(0)), "face/" + muscle + ": expected as many directions as tetrahedra");
  EXPECT_EQ(replaced(muscle, 16, number(0)), "face/" + muscle + ": direction 1: expected one of length 1");
  EXPECT_EQ(replaced(muscle, 28, number(1.5)), "face/" + muscle + ": share 1: expected a number from 0 to 1");
  EXPECT_EQ(replaced(frame, 0, whole(57)), "face/" + frame + ": the number of controls: 57, expected 26");
  EXPECT_EQ(replaced(frame, 8, number(-.5)),
            "face/" + frame + ": the activation of b: expected a number from 0 to 1");
  EXPECT_EQ(replaced(frame, 12, number(1.5)), "face/" + frame + ": the cranium: expected a rotation");
  EXPECT_EQ(replaced(frame, 12 + 48, number(-1)), "face/" + frame + ": the jaw: expected a rotation");
  EXPECT_EQ(with("muscle_list.txt", "2\na a\n"), "face/muscle_list.txt: a comes twice");
  EXPECT_EQ(with("muscle_list.txt", "x\n"), "face/muscle_list.txt: expected how many names there are");
  EXPECT_EQ(with("muscle_list.txt", "2000000000 a b"), "face/muscle_list.txt: ends before name 3 of 2000000000");
  EXPECT_EQ(with("muscle_list.txt", "1 ../a"), "face/muscle_list.txt: name 1: expected a part of a file's name");
  EXPECT_EQ(with("peak_isometric_stress_list.txt", "1 a nan"),
            "face/peak_isometric_stress_list.txt: a: expected a number from 0 to 1e12, in Pa");
  EXPECT_EQ(with("attachment_list.txt", "1 cranium"), "face/attachment_list.txt: expected an attachment named jaw");
  EXPECT_EQ(with("jaw.attached_nodes", whole(1) + whole(10)),
            "face/jaw.attached_nodes: node 1: 10, expected one from 1 to 9");
  EXPECT_EQ(error(good, "controls = \"face\"\n[[key]]\ntime = 1\n"),
            "a.toml:5:1: key: expected none beside `controls`, which has its own");
  EXPECT_EQ(error(good, "[[bone]]\nname = \"a\"\nfrom = [0, 0, 0]\nto = [0, 1, 1]\n"),
            "a.toml:4:1: bone: expected none beside [facesim], which has its own");
  EXPECT_EQ(error(good, "controls = \"nowhere\"\n"),
            "nowhere/storytelling_controls.0: cannot be read: No such file or directory");
  write_facesim(path("face"), good);
  limit_memory(100);
  const std::string message = error_of([&] { read_facesim(path("face"), std::nullopt); });
  limit_memory(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(message.starts_with(path("face") + "/face_simulation.tet: reading it needs ")) << message;
}

}  // namespace
}  // namespace lockstep::production_face
