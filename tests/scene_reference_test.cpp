// scenes/README.md against the readers: every section has the keys that its reader knows, a default is what the reader
// takes where the key is left out, and what is just outside of a range is refused while its ends are not. Run from the
// root of the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "common/memory.h"
#include "common/toml.h"
#include "tests/facesim_files.h"
#include "tests/scene_document.h"
#include "tests/scene_hash.h"
#include "tests/temporary_folder.h"
#include "verify/domain.h"

namespace lockstep {
namespace {

// --- Scenes with one of each table: where a table is not reached, another scene has it.

const std::string sheet =
    "[sheet]\nrows = 3\ncolumns = 4\norigin = [0, 0, 0]\nwidth = [1, 0, 0]\nheight = [0, 1, 0]\nmass = 1\n";
const std::string fluid_block =
    "kind = \"fluid\"\nparticles_per_metre = 100\n[[block]]\nmin = [0, 0, 0]\nmax = [0.03, 0.03, 0.03]\n";
const std::string level = "kind = \"levelset\"\npoints = [10, 11, 12]\n";
const std::string box_of_cells = "kind = \"production_fluid\"\ncells = [10, 11, 12]\n";
const std::string weave =
    "kind = \"production_cloth\"\n[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [0, 1, 0]\n"
    "squares = [2, 3]\n";
const std::string bodies = "kind = \"rigid\"\nframes = 2\n[[body]]\nbox = [1, 1, 1]\nmass = 1\n";

std::string base_of(const std::string& domain, const std::string& section) {
  const std::map<std::string, std::string> bases = {
      {"fluid", fluid_block + "[holds]\n"},
      {"cloth", "kind = \"cloth\"\n" + sheet + "pull = { edge = \"left\", by = [0, 0, 0] }\n" +
                    "[[plane]]\nnormal = [0, 1, 0]\npoint = [0, 0, 0]\n[[sphere]]\ncentre = [0, 0, 0]\nradius = 1\n"
                    "[[capsule]]\nfrom = [0, 0, 0]\nto = [0, 1, 0]\nradius = 1\n"
                    "[[box]]\ncentre = [0, 0, 0]\nhalf = [1, 1, 1]\n"},
      {"cloth/mesh", "kind = \"cloth\"\n[mesh]\nfile = \"a.obj\"\nmass = 1\n"},
      {"levelset", level + "[[sphere]]\ncentre = [0.5, 0.5, 0.5]\nradius = 0.3\n[[box]]\ncentre = [0.5, 0.5, 0.5]\n"
                           "half = [0.2, 0.2, 0.2]\n[[torus]]\ncentre = [0.5, 0.5, 0.5]\nring = 0.3\ntube = 0.1\n"},
      {"levelset/mesh", level + "[mesh]\nfile = \"a.obj\"\n"},
      {"rigid", bodies},
      {"rigid/hull", bodies + "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n"},
      {"rigid/capsule", "kind = \"rigid\"\nframes = 2\n[[body]]\ncapsule = { half = 1, radius = 1 }\n"},
      {"rigid/part", "kind = \"rigid\"\nframes = 2\n[[body]]\n[[body.part]]\nbox = [1, 1, 1]\n"},
      {"rigid/pyramid", bodies + "[[pyramid]]\nlayers = 2\n"},
      {"rigid/stack", bodies + "[[stack]]\ncount = 2\nbox = [1, 1, 1]\n"},
      {"rigid/wall", bodies + "[[wall]]\ncourses = 2\nbricks = 2\n"},
      {"rigid/castle", bodies + "[[castle]]\n"},
      {"rigid/dominoes", bodies + "[[dominoes]]\ncount = 2\n"},
      {"rigid/pit", bodies + "[[pit]]\nof = \"boxes\"\ncount = 2\n"},
      {"rigid/soup", bodies + "[[soup]]\nof = \"boxes\"\ncount = 2\noverlapping = 0.1\n"},
      {"production_fluid", box_of_cells + "[pool]\nheight = 0.4\n[[liquid]]\ncentre = [0.5, 0.8, 0.5]\n"
                                          "radius = 0.2\n[[obstacle]]\ncentre = [0.5, 0.2, 0.5]\nradius = 0.2\n"
                                          "[[air]]\ncentre = [0.5, 0.4, 0.5]\nradius = 0.1\n"
                                          "[[source]]\ncentre = [0.5, 0.9, 0.5]\nradius = 0.1\n"},
      {"production_fluid/mesh", box_of_cells + "[pool]\nheight = 0.4\n[mesh]\nfile = \"a.obj\"\n"},
      {"production_face",
       "kind = \"production_face\"\n[lattice]\ncells = [1, 2, 1]\nspacing = 0.01\n[[muscle]]\n"
       "name = \"a\"\nfrom = [0, 0, 0]\nto = [0.01, 0.02, 0.01]\nradius = 0.01\n[[bone]]\nname = \"b\"\nfrom = [0, 0, "
       "0]\n"
       "to = [0, 1, 1]\n[[key]]\ntime = 1\n[[key.pull]]\nmuscle = \"a\"\nactivation = 1\n[[key.move]]\nbone = \"b\"\n"},
      {"production_face/mesh", "kind = \"production_face\"\n[mesh]\nfile = \"a.veg\"\n"},
      {"production_face/facesim", "kind = \"production_face\"\n[facesim]\nfolder = \"facesim\"\n"},
      {"production_face/face", "kind = \"production_face\"\n[face]\nspacing = 0.012\n"},
      {"production_cloth",
       weave + "[material]\n[contact]\n[[hold]]\nfrom = [0, 0, 0]\nto = [0, 0, 0]\n[[hold.key]]\ntime = 1\n" +
           "[[plane]]\nnormal = [0, 1, 0]\npoint = [0, -1, 0]\n[[sphere]]\ncentre = [0, 0, 0]\n"
           "radius = 1\n[[capsule]]\nfrom = [0, 0, 0]\nto = [0, 1, 0]\nradius = 1\n[[box]]\n"
           "centre = [0, 0, 0]\nhalf = [1, 1, 1]\n"},
      {"production_cloth/solid", weave + "[[solid]]\nfile = \"a.obj\"\nspacing = 0.1\n"},
      {"production_cloth/tube",
       "kind = \"production_cloth\"\n[[tube]]\nfrom = [0, 0, 0]\nto = [1, 0, 0]\nradius = 0.5\n"
       "squares = [5, 3]\n"},
      {"production_cloth/mesh", "kind = \"production_cloth\"\n[[mesh]]\nfile = \"a.obj\"\n"},
      {"linear", "kind = \"linear\"\n[poisson]\ncells = 12\n"},
      {"linear/elasticity", "kind = \"linear\"\n[elasticity]\npoints = 2\n"},
      {"linear/file", "kind = \"linear\"\n[file]\nmatrix = \"a.mtx\"\n"}};
  const auto own = bases.find(domain + '/' + section);
  return own != bases.end() ? own->second : bases.at(domain);
}

// The first table of that name, at the top level or within another.
toml::table* find_table(toml::table& table, const std::string& name) {
  if (name.empty()) return &table;
  for (auto&& [key, value] : table) {
    toml::node* node = value.is_array() && !value.as_array()->empty() ? value.as_array()->get(0) : &value;
    if (toml::table* inner = node->as_table()) {
      if (key.str() == name) return inner;
      if (toml::table* found = find_table(*inner, name)) return found;
    }
  }
  return nullptr;
}

std::string text_of(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

// Ranges of whole numbers end in many digits, all others in a power of ten, a fraction or 1 or 100.
bool is_whole(const Row& row) {
  return std::regex_match(row.range, std::regex("[0-9]+ to [0-9]{3,}")) && row.range != "0 to 100";
}

struct SceneReference : TemporaryFolder {
  const Document document = read_document();

  SceneReference() {
    limit_memory(1e8);
    write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    write_bytes(path("a.veg"), "*VERTICES\n4 3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n*ELEMENTS\nTET\n1 4\n1 1 2 3 4\n");
    production_face::write_facesim(path("facesim"), production_face::small_facesim_files());
    write_bytes(path("a.mtx"), "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2\n2 1 -1\n2 2 2\n");
  }
  ~SceneReference() override { limit_memory(std::numeric_limits<double>::infinity()); }

  // The scene with one more key, or another value of one, without its place; the value as TOML.
  std::string write(const std::string& domain, const std::string& section, const std::string& key,
                    const std::string& value) const {
    toml::table scene = toml::parse(base_of(domain, section));
    toml::table* table = find_table(scene, section);
    if (!table) throw std::logic_error("no table " + section + " in the scene of the test");
    if (!key.empty()) {
      const Section& rows = document.at(domain).at(section);
      for (const Row& row : rows)  // one of several makes room for another
        if (const auto self = std::ranges::find(rows, key, &Row::key);
            self != rows.end() && row.otherwise == "one of" && self->otherwise == "one of")
          table->erase(row.key);
      table->insert_or_assign(key, *toml::parse("x = " + value).get("x"));
    }
    std::ostringstream text;
    text << scene;
    write_bytes(path("a.toml"), text.str() + '\n');
    return path("a.toml");
  }
  std::string error(const std::string& domain, const std::string& section, const std::string& key,
                    const std::string& value) const {
    const std::string scene = write(domain, section, key, value);
    const std::string message = error_of([&] { hash_of_scene(domain, scene); });
    return std::regex_replace(message, std::regex("^[^:]*:[0-9]+:[0-9]+: "), "");
  }

  template <class Action>
  void for_each_row(Action action) const {
    for (const auto& [domain, sections] : document)
      for (const auto& [section, rows] : sections)
        for (const Row& row : rows) {
          SCOPED_TRACE(domain + " [" + section + "] " + row.key);
          action(domain, section, row);
        }
  }
};

TEST_F(SceneReference, HasEveryDomain) {
  std::set<std::string> domains, documented;
  for (const verify::Domain& domain : verify::domains()) domains.insert(domain.name);
  for (const auto& [domain, _] : document) documented.insert(domain);
  EXPECT_EQ(documented, domains);
}

// A reader that is given a key it does not know says which it knows.
TEST_F(SceneReference, HasTheKeysOfTheReaders) {
  for (const auto& [domain, sections] : document)
    for (const auto& [section, rows] : sections) {
      std::set<std::string> documented, known;
      for (const Row& row : rows) EXPECT_TRUE(documented.insert(row.key).second) << row.key << " comes twice";
      const std::string message = error(domain, section, "unknown", "1"),
                        begin = "unknown key unknown, expected one of: ";
      ASSERT_TRUE(message.starts_with(begin)) << message;
      std::istringstream words(message.substr(begin.size()));
      for (std::string word; std::getline(words >> std::ws, word, ',');) known.insert(word);
      EXPECT_EQ(documented, known) << domain << " [" << section << ']';
    }
}

// Every key that is a table has a section.
TEST_F(SceneReference, HasASectionForEachTable) {
  for_each_row([&](const std::string& domain, const std::string& section, const Row& row) {
    const bool is_table = error(domain, section, row.key, "1").find("expected a table") != std::string::npos ||
                          error(domain, section, row.key, "1").find("or more tables") != std::string::npos;
    if (is_table) {
      EXPECT_TRUE(document.at(domain).contains(row.key)) << row.key;
    }
  });
}

TEST_F(SceneReference, DefaultsAreWhatTheReadersTake) {
  int checked = 0;
  for_each_row([&](const std::string& domain, const std::string& section, const Row& row) {
    if (!row.otherwise.starts_with('`')) return;
    const std::string value = row.otherwise == "`1/60`" ? "0.016666666666666666" : bare(row.otherwise);
    const std::uint64_t without = hash_of_scene(domain, write(domain, section, "", ""));
    EXPECT_EQ(hash_of_scene(domain, write(domain, section, row.key, value)), without);
    ++checked;
  });
  EXPECT_GE(checked, 60);
}

// A hash that did not see a key would take any default for right.
TEST_F(SceneReference, OtherValuesMakeOtherScenes) {
  for_each_row([&](const std::string& domain, const std::string& section, const Row& row) {
    if (!row.otherwise.starts_with('`')) return;
    const std::string value = bare(row.otherwise);
    const auto other_than = [&]() -> std::string {
      const std::map<std::string, std::string> words = {{"true", "false"},
                                                        {"false", "true"},
                                                        {"[]", "[\"right\"]"},
                                                        {"[0, 0, 0, 1]", "[0, 1, 0, 0]"},
                                                        {"0", "0.5"},
                                                        {"\"springs\"", "\"stvk\""},
                                                        {"\"rigid\"", "\"inelastic\""},
                                                        {"\"quadratic\"", "\"hinges\""}};
      if (const auto word = words.find(value); word != words.end() && !(value == "0" && is_whole(row)))
        return word->second;
      if (value.starts_with('[')) return "[0.5, 0.25, 0.125]";
      return is_whole(row) ? std::to_string(std::stoi(value) + 1) : text_of(.5 * std::stod(value));
    };
    const std::string other = other_than();
    if (row.key == "seed") return;  // there is nothing random in these scenes
    const std::uint64_t without = hash_of_scene(domain, write(domain, section, "", ""));
    EXPECT_NE(hash_of_scene(domain, write(domain, section, row.key, other)), without) << other;
  });
}

TEST_F(SceneReference, RangesAreThoseOfTheReaders) {
  int checked = 0;
  for_each_row([&](const std::string& domain, const std::string& section, const Row& row) {
    std::smatch range;
    if (!std::regex_match(row.range, range, std::regex("(\\S+) to ([-0-9.e]+)"))) return;
    // As the key takes it: a number or a list of them, of which one has this value.
    const std::string three = error(domain, section, row.key, "0.5");
    const bool is_list = three.find("three") != std::string::npos;
    const auto written = [&](const std::string& x) {
      const std::string rest = is_whole(row) ? "9" : "1";
      return is_list ? "[" + rest + ", " + x + ", " + rest + "]" : x;
    };
    const auto check = [&](const std::string& outside, const std::string& end) {
      const std::string refused = error(domain, section, row.key, written(outside));
      EXPECT_TRUE(refused.starts_with(row.key + ": expected ")) << outside << ": " << refused;
      EXPECT_NE(error(domain, section, row.key, written(end)), refused) << end;
    };
    const double low = std::stod(range[1]), high = std::stod(range[2]);
    if (is_whole(row) && !is_list) {
      check(std::to_string(std::stoll(range[1]) - 1), range[1]);
      if (high < 9e18) check(std::to_string(std::stoll(range[2]) + 1), range[2]);
    } else if (is_whole(row)) {
      check(std::to_string(std::stoll(range[1]) - 1), range[1]);
    } else {
      check(text_of(low > 0 ? low * (1 - 1e-9) : low < 0 ? low * (1 + 1e-9) : -1e-9), text_of(low));
      check(text_of(high * (1 + 1e-9)), text_of(high));
    }
    ++checked;
  });
  EXPECT_GE(checked, 70);
}

// The examples.
TEST_F(SceneReference, ExamplesLoad) {
  limit_memory(std::numeric_limits<double>::infinity());
  const std::string text = read_bytes("scenes/README.md");
  const std::regex example("```toml\n([^`]*)```");
  std::set<std::string> domains;
  for (auto match = std::sregex_iterator(text.begin(), text.end(), example); match != std::sregex_iterator(); ++match) {
    write_bytes(path("a.toml"), (*match)[1]);
    const std::string& domain = verify::domain_of_scene(path("a.toml")).name;
    EXPECT_NO_THROW(hash_of_scene(domain, path("a.toml")));
    domains.insert(domain);
  }
  EXPECT_EQ(domains.size(), document.size());
}

}  // namespace
}  // namespace lockstep
