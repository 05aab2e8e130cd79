// Thin layer of our own, or Google Highway? Two kernels of the SPH fluid, written five ways, timed on one core:
//
//   scalar            the serial text
//   omp simd          the serial text under #pragma omp simd
//   thin layer        lane text over common/simd.h
//   Highway façade    the same lane text over the same names, implemented by Highway
//   Highway direct    Highway as its manual uses it: named operations, since vectors on some of its targets (SVE,
//                     RISC-V) have no operators
//
// Prints the table of README.md. Fails if a way computes something else: all may differ from the scalar one as two
// orders of adding the same n terms may, by 2 (n - 1) u sum|term|, and the three lane forms must give the same bits.

#include "common/simd.h"

#include <hwy/highway.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

constexpr int lanes = 16;
constexpr float h = 0.1f, h2 = h * h;
constexpr int own = 5;  // particles of a cell; they come first among its candidates

// The candidates of a cell, those of the 27 cells around it, packed; filled up to whole vectors with ones far away.
struct Cell {
  int n;
  std::vector<float> x, y, z, vx, vy, vz, rho;
};

struct Sums {
  float pressure[3], viscosity[3];
};

float max(float a, float b) { return a > b ? a : b; }

namespace scalar {

//< density scalar
void density(const Cell& c, float* rho) {
  for (int i = 0; i < own; ++i) {
    float sum = 0;
    for (int j = 0; j < c.n; ++j) {
      const float dx = c.x[i] - c.x[j], dy = c.y[i] - c.y[j], dz = c.z[i] - c.z[j];
      const float r2 = dx * dx + dy * dy + dz * dz;
      const float t = max(h2 - r2, 0);
      sum += t * t * t;
    }
    rho[i] = sum;
  }
}
//>

//< force scalar
void force(const Cell& c, Sums* sums) {
  for (int i = 0; i < own; ++i) {
    float px = 0, py = 0, pz = 0, ux = 0, uy = 0, uz = 0;
    for (int j = 0; j < c.n; ++j) {
      const float dx = c.x[i] - c.x[j], dy = c.y[i] - c.y[j], dz = c.z[i] - c.z[j];
      const float r2 = dx * dx + dy * dy + dz * dz;
      if (r2 < h2) {
        const float d = std::sqrt(max(r2, 1e-12f));
        const float rho = c.rho[j];
        const float q = (h - d) / (d * rho);
        const float p = q * (h - d) * (c.rho[i] + rho - 2000);
        const float u = q * d;
        px += dx * p;
        py += dy * p;
        pz += dz * p;
        ux += (c.vx[j] - c.vx[i]) * u;
        uy += (c.vy[j] - c.vy[i]) * u;
        uz += (c.vz[j] - c.vz[i]) * u;
      }
    }
    sums[i] = {{px, py, pz}, {ux, uy, uz}};
  }
}
//>

// The sums with every term positive, as those of the density are.
float magnitude_density(const Cell& c, int i) {
  float rho[own];
  density(c, rho);
  return rho[i];
}
Sums magnitude_force(const Cell& c, int i) {
  Sums s{};
  for (int j = 0; j < c.n; ++j) {
    const float dx = c.x[i] - c.x[j], dy = c.y[i] - c.y[j], dz = c.z[i] - c.z[j];
    const float r2 = dx * dx + dy * dy + dz * dz;
    if (r2 >= h2) continue;
    const float d = std::sqrt(max(r2, 1e-12f));
    const float q = (h - d) / (d * c.rho[j]);
    const float p = std::fabs(q * (h - d) * (c.rho[i] + c.rho[j] - 2000)), u = q * d;
    const float dp[3] = {dx, dy, dz}, dv[3] = {c.vx[j] - c.vx[i], c.vy[j] - c.vy[i], c.vz[j] - c.vz[i]};
    for (int k = 0; k < 3; ++k) {
      s.pressure[k] += std::fabs(dp[k]) * p;
      s.viscosity[k] += std::fabs(dv[k]) * u;
    }
  }
  return s;
}

}  // namespace scalar

namespace omp_simd {

//< density omp simd
void density(const Cell& c, float* rho) {
  const float *x = c.x.data(), *y = c.y.data(), *z = c.z.data();
  for (int i = 0; i < own; ++i) {
    const float xi = x[i], yi = y[i], zi = z[i];
    float sum = 0;
#pragma omp simd reduction(+ : sum) simdlen(16)
    for (int j = 0; j < c.n; ++j) {
      const float dx = xi - x[j], dy = yi - y[j], dz = zi - z[j];
      const float r2 = dx * dx + dy * dy + dz * dz;
      const float t = max(h2 - r2, 0);
      sum += t * t * t;
    }
    rho[i] = sum;
  }
}
//>

//< force omp simd
void force(const Cell& c, Sums* sums) {
  const float *x = c.x.data(), *y = c.y.data(), *z = c.z.data();
  const float *vx = c.vx.data(), *vy = c.vy.data(), *vz = c.vz.data(), *density = c.rho.data();
  for (int i = 0; i < own; ++i) {
    const float xi = x[i], yi = y[i], zi = z[i], vxi = vx[i], vyi = vy[i], vzi = vz[i], rhoi = density[i];
    float px = 0, py = 0, pz = 0, ux = 0, uy = 0, uz = 0;
#pragma omp simd reduction(+ : px, py, pz, ux, uy, uz) simdlen(16)
    for (int j = 0; j < c.n; ++j) {
      const float dx = xi - x[j], dy = yi - y[j], dz = zi - z[j];
      const float r2 = dx * dx + dy * dy + dz * dz;
      const bool near = r2 < h2;
      const float d = std::sqrt(max(r2, 1e-12f));
      const float rho = density[j];
      const float q = (h - d) / (d * rho);
      const float p = near ? q * (h - d) * (rhoi + rho - 2000) : 0;
      const float u = near ? q * d : 0;
      px += dx * p;
      py += dy * p;
      pz += dz * p;
      ux += (vx[j] - vxi) * u;
      uy += (vy[j] - vyi) * u;
      uz += (vz[j] - vzi) * u;
    }
    sums[i] = {{px, py, pz}, {ux, uy, uz}};
  }
}
//>

}  // namespace omp_simd

// Layers: the part of the interface of common/simd.h that the kernels need.

struct Thin {
  using floatv = lockstep::floatv;
  using maskv = lockstep::maskv;
  static floatv load(const float* p) { return lockstep::load(p); }
};

namespace facade {

namespace hn = hwy::HWY_NAMESPACE;
constexpr hn::FixedTag<float, 16> tag;

struct floatv {
  hn::Vec<decltype(tag)> v;
  HWY_INLINE floatv(hn::Vec<decltype(tag)> v) : v(v) {}
  HWY_INLINE floatv(float x) : v(hn::Set(tag, x)) {}
};
struct maskv {
  hn::Mask<decltype(tag)> m;
};

HWY_INLINE floatv load(const float* p) { return hn::LoadU(tag, p); }
HWY_INLINE floatv operator+(floatv a, floatv b) { return hn::Add(a.v, b.v); }
HWY_INLINE floatv operator-(floatv a, floatv b) { return hn::Sub(a.v, b.v); }
HWY_INLINE floatv operator*(floatv a, floatv b) { return hn::Mul(a.v, b.v); }
HWY_INLINE floatv operator/(floatv a, floatv b) { return hn::Div(a.v, b.v); }
HWY_INLINE floatv& operator+=(floatv& a, floatv b) { return a = a + b; }
HWY_INLINE floatv max(floatv a, floatv b) { return hn::Max(a.v, b.v); }
HWY_INLINE floatv sqrt(floatv a) { return hn::Sqrt(a.v); }
HWY_INLINE maskv operator<(floatv a, floatv b) { return {hn::Lt(a.v, b.v)}; }
HWY_INLINE floatv select(maskv m, floatv a, floatv b) { return hn::IfThenElse(m.m, a.v, b.v); }
HWY_INLINE float reduce_add(floatv a) { return hn::GetLane(hn::SumOfLanes(tag, a.v)); }

}  // namespace facade

struct Facade {
  using floatv = facade::floatv;
  using maskv = facade::maskv;
  static floatv load(const float* p) { return facade::load(p); }
};

template <class Layer>
struct Lanes : Layer {
  using floatv = typename Layer::floatv;
  using maskv = typename Layer::maskv;
  using Layer::load;

  //< density lanes
  static void density(const Cell& c, float* rho) {
    for (int i = 0; i < own; ++i) {
      floatv sum = 0;
      for (int j = 0; j < c.n; j += lanes) {
        const floatv dx = c.x[i] - load(&c.x[j]), dy = c.y[i] - load(&c.y[j]), dz = c.z[i] - load(&c.z[j]);
        const floatv r2 = dx * dx + dy * dy + dz * dz;
        const floatv t = max(h2 - r2, 0);
        sum += t * t * t;
      }
      rho[i] = reduce_add(sum);
    }
  }
  //>

  //< force lanes
  static void force(const Cell& c, Sums* sums) {
    for (int i = 0; i < own; ++i) {
      floatv px = 0, py = 0, pz = 0, ux = 0, uy = 0, uz = 0;
      for (int j = 0; j < c.n; j += lanes) {
        const floatv dx = c.x[i] - load(&c.x[j]), dy = c.y[i] - load(&c.y[j]), dz = c.z[i] - load(&c.z[j]);
        const floatv r2 = dx * dx + dy * dy + dz * dz;
        const maskv near = r2 < h2;
        const floatv d = sqrt(max(r2, 1e-12f));
        const floatv rho = load(&c.rho[j]);
        const floatv q = (h - d) / (d * rho);
        const floatv p = select(near, q * (h - d) * (c.rho[i] + rho - 2000), 0);
        const floatv u = select(near, q * d, 0);
        px += dx * p;
        py += dy * p;
        pz += dz * p;
        ux += (load(&c.vx[j]) - c.vx[i]) * u;
        uy += (load(&c.vy[j]) - c.vy[i]) * u;
        uz += (load(&c.vz[j]) - c.vz[i]) * u;
      }
      sums[i] = {{reduce_add(px), reduce_add(py), reduce_add(pz)}, {reduce_add(ux), reduce_add(uy), reduce_add(uz)}};
    }
  }
  //>
};

namespace highway {

namespace hn = hwy::HWY_NAMESPACE;

//< density Highway
void density(const Cell& c, float* rho) {
  const hn::FixedTag<float, 16> tag;
  using V = hn::Vec<decltype(tag)>;
  for (int i = 0; i < own; ++i) {
    const V xi = hn::Set(tag, c.x[i]), yi = hn::Set(tag, c.y[i]), zi = hn::Set(tag, c.z[i]);
    V sum = hn::Zero(tag);
    for (int j = 0; j < c.n; j += lanes) {
      const V dx = hn::Sub(xi, hn::LoadU(tag, &c.x[j]));
      const V dy = hn::Sub(yi, hn::LoadU(tag, &c.y[j]));
      const V dz = hn::Sub(zi, hn::LoadU(tag, &c.z[j]));
      const V r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const V t = hn::Max(hn::Sub(hn::Set(tag, h2), r2), hn::Zero(tag));
      sum = hn::Add(sum, hn::Mul(hn::Mul(t, t), t));
    }
    rho[i] = hn::GetLane(hn::SumOfLanes(tag, sum));
  }
}
//>

//< force Highway
void force(const Cell& c, Sums* sums) {
  const hn::FixedTag<float, 16> tag;
  using V = hn::Vec<decltype(tag)>;
  const auto total = [&](V v) { return hn::GetLane(hn::SumOfLanes(tag, v)); };
  for (int i = 0; i < own; ++i) {
    const V xi = hn::Set(tag, c.x[i]), yi = hn::Set(tag, c.y[i]), zi = hn::Set(tag, c.z[i]);
    const V vxi = hn::Set(tag, c.vx[i]), vyi = hn::Set(tag, c.vy[i]), vzi = hn::Set(tag, c.vz[i]);
    V px = hn::Zero(tag), py = px, pz = px, ux = px, uy = px, uz = px;
    for (int j = 0; j < c.n; j += lanes) {
      const V dx = hn::Sub(xi, hn::LoadU(tag, &c.x[j]));
      const V dy = hn::Sub(yi, hn::LoadU(tag, &c.y[j]));
      const V dz = hn::Sub(zi, hn::LoadU(tag, &c.z[j]));
      const V r2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const auto near = hn::Lt(r2, hn::Set(tag, h2));
      const V d = hn::Sqrt(hn::Max(r2, hn::Set(tag, 1e-12f)));
      const V rho = hn::LoadU(tag, &c.rho[j]);
      const V h_d = hn::Sub(hn::Set(tag, h), d);
      const V q = hn::Div(h_d, hn::Mul(d, rho));
      const V excess = hn::Sub(hn::Add(hn::Set(tag, c.rho[i]), rho), hn::Set(tag, 2000.0f));
      const V p = hn::IfThenElseZero(near, hn::Mul(hn::Mul(q, h_d), excess));
      const V u = hn::IfThenElseZero(near, hn::Mul(q, d));
      px = hn::Add(px, hn::Mul(dx, p));
      py = hn::Add(py, hn::Mul(dy, p));
      pz = hn::Add(pz, hn::Mul(dz, p));
      ux = hn::Add(ux, hn::Mul(hn::Sub(hn::LoadU(tag, &c.vx[j]), vxi), u));
      uy = hn::Add(uy, hn::Mul(hn::Sub(hn::LoadU(tag, &c.vy[j]), vyi), u));
      uz = hn::Add(uz, hn::Mul(hn::Sub(hn::LoadU(tag, &c.vz[j]), vzi), u));
    }
    sums[i] = {{total(px), total(py), total(pz)}, {total(ux), total(uy), total(uz)}};
  }
}
//>

}  // namespace highway

// 64 cells: more than a branch predictor learns by heart, and small enough (250 kB) to stay in the second cache.
std::vector<Cell> make_cells() {
  std::mt19937 engine(1);
  const auto uniform = [&](float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine); };
  std::vector<Cell> cells(64);
  for (Cell& c : cells) {
    c.n = std::uniform_int_distribution<int>(125, 145)(engine);
    for (int j = 0; j < (c.n + lanes - 1) / lanes * lanes; ++j) {
      const float side = j < own ? h / 2 : 3 * h / 2, away = j < c.n ? 0.0f : 100 * h;
      for (auto* x : {&c.x, &c.y, &c.z}) x->push_back(away + uniform(-side, side));
      for (auto* v : {&c.vx, &c.vy, &c.vz}) v->push_back(uniform(-1, 1));
      c.rho.push_back(uniform(950, 1050));
    }
  }
  return cells;
}

struct Result {
  float rho[own];
  Sums sums[own];
};

struct Way {
  const char* name;
  const char* text;  // which text between "//< kernel text" and "//>" it compiles
  void (*density)(const Cell&, float*);
  void (*force)(const Cell&, Sums*);
  std::vector<Result> results;
  std::vector<double> density_ns, force_ns;  // per candidate, one of each repeat
};

bool same_bits(const Way& a, const Way& b) {
  return std::memcmp(a.results.data(), b.results.data(), a.results.size() * sizeof(Result)) == 0;
}

bool same_terms(const std::vector<Cell>& cells, const Way& a, const Way& b) {
  bool same = true;
  const auto compare = [&](float x, float y, float magnitude, int n) {
    same = same && std::fabs(x - y) <= 2 * static_cast<float>(n - 1) * 0x1p-24f * magnitude;
  };
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (int i = 0; i < own; ++i) {
      const Cell& c = cells[k];
      const Result &ra = a.results[k], &rb = b.results[k];
      const Sums &sa = ra.sums[i], &sb = rb.sums[i], magnitude = scalar::magnitude_force(c, i);
      compare(ra.rho[i], rb.rho[i], scalar::magnitude_density(c, i), c.n);
      for (int x = 0; x < 3; ++x) {
        compare(sa.pressure[x], sb.pressure[x], magnitude.pressure[x], c.n);
        compare(sa.viscosity[x], sb.viscosity[x], magnitude.viscosity[x], c.n);
      }
    }
  return same;
}

// The tokens of a kernel's text in this file.
std::vector<std::string> tokens(const std::string& kernel, const std::string& text) {
  std::ifstream file(__FILE__);
  const std::string all{std::istreambuf_iterator<char>(file), {}};
  const std::string head = "//< " + kernel + " " + text + "\n";
  const std::size_t begin = all.find(head);
  if (begin == all.npos) throw std::runtime_error("no " + head + " in " __FILE__ ": run where it was compiled");
  const std::string body = all.substr(begin + head.size(), all.find("//>", begin) - begin - head.size());
  static const std::regex token(R"(\w+(\.\w+)?|::|[-+*/<>=]=|\+\+|\S)");
  return {std::sregex_token_iterator(body.begin(), body.end(), token), {}};
}

// 2 L / (|a| + |b|), L the length of the longest common subsequence: 1 for the same text.
double similarity(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (const auto& s : a) {
    std::size_t diagonal = 0;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t up = row[j + 1];
      row[j + 1] = s == b[j] ? diagonal + 1 : std::max(up, row[j]);
      diagonal = up;
    }
  }
  return 2 * static_cast<double>(row.back()) / static_cast<double>(a.size() + b.size());
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + v.size() / 2, v.end());
  return v[v.size() / 2];
}

}  // namespace

int main() {
  const std::vector<Cell> cells = make_cells();
  double candidates = 0;
  for (const Cell& c : cells) candidates += own * c.n;

  Way ways[] = {{"scalar", "scalar", scalar::density, scalar::force, {}, {}, {}},
                {"omp simd", "omp simd", omp_simd::density, omp_simd::force, {}, {}, {}},
                {"thin layer", "lanes", Lanes<Thin>::density, Lanes<Thin>::force, {}, {}, {}},
                {"Highway façade", "lanes", Lanes<Facade>::density, Lanes<Facade>::force, {}, {}, {}},
                {"Highway direct", "Highway", highway::density, highway::force, {}, {}, {}}};
  for (Way& w : ways) w.results.resize(cells.size());

  const auto time = [&](auto kernel) {
    using clock = std::chrono::steady_clock;
    constexpr int rounds = 20;
    const auto start = clock::now();
    for (int round = 0; round < rounds; ++round)
      for (std::size_t k = 0; k < cells.size(); ++k) kernel(k);
    return std::chrono::duration<double, std::nano>(clock::now() - start).count() / rounds / candidates;
  };
  // The ways take turns, so that what disturbs the machine disturbs them alike.
  for (int repeat = 0; repeat < 101; ++repeat)
    for (Way& w : ways) {
      w.density_ns.push_back(time([&](std::size_t k) { w.density(cells[k], w.results[k].rho); }));
      w.force_ns.push_back(time([&](std::size_t k) { w.force(cells[k], w.results[k].sums); }));
    }

  const Way &serial = ways[0], &thin = ways[2], &facade = ways[3], &direct = ways[4];
  for (const Way& w : ways)
    if (!same_terms(cells, w, serial)) return std::fprintf(stderr, "%s sums other terms\n", w.name), 1;
  for (const Way& w : {facade, direct})
    if (!same_bits(w, thin)) return std::fprintf(stderr, "%s has other bits than %s\n", w.name, thin.name), 1;

  std::printf(
      "| way | density ns: min | median | force ns: min | median | tokens: density | force "
      "| like the scalar text: density | force |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (const Way& w : ways) {
    const auto density = tokens("density", w.text), force = tokens("force", w.text);
    std::printf("| %s | %.3f | %.3f | %.3f | %.3f | %zu | %zu | %.2f | %.2f |\n", w.name,
                *std::min_element(w.density_ns.begin(), w.density_ns.end()), median(w.density_ns),
                *std::min_element(w.force_ns.begin(), w.force_ns.end()), median(w.force_ns), density.size(),
                force.size(), similarity(density, tokens("density", "scalar")),
                similarity(force, tokens("force", "scalar")));
  }
}
