#include "common/production_cloth/orientation.h"

#include <cmath>

namespace lockstep::production_cloth {
namespace {

// A sum of doubles without rounding: components that do not overlap, the least first.
class ExactSum {
 public:
  void add(double x) {
    for (int i = 0; i < count_; ++i) {
      const double sum = x + component_[i], from = sum - x;
      component_[i] = (x - (sum - from)) + (component_[i] - from);  // what rounding took from the sum
      x = sum;
    }
    component_[count_++] = x;
  }
  // a b c of floats, times a sign: a b is exact in a double.
  void add_product(float a, float b, float c, double sign) {
    const double ab = sign * a * b, product = ab * c;
    add(product);
    add(std::fma(ab, c, -product));
  }
  int sign() const {
    for (int i = count_ - 1; i >= 0; --i)
      if (component_[i] != 0) return component_[i] > 0 ? 1 : -1;
    return 0;
  }

 private:
  double component_[48];  // as many as are added at most: two of each of 24 products
  int count_ = 0;
};

// Adds the determinant of a, b, c.
void add_determinant(ExactSum& sum, const Vector3<float>& a, const Vector3<float>& b, const Vector3<float>& c,
                     double sign) {
  sum.add_product(a.x, b.y, c.z, sign), sum.add_product(a.x, b.z, c.y, -sign);
  sum.add_product(a.y, b.z, c.x, sign), sum.add_product(a.y, b.x, c.z, -sign);
  sum.add_product(a.z, b.x, c.y, sign), sum.add_product(a.z, b.y, c.x, -sign);
}

constexpr double u = 0x1p-53;

}  // namespace

int orient3d(const Vector3<float>& a, const Vector3<float>& b, const Vector3<float>& c, const Vector3<float>& d) {
  const auto minus_a = [&](const Vector3<float>& p) {
    return Vector3<double>{double(p.x) - a.x, double(p.y) - a.y, double(p.z) - a.z};
  };
  const Vector3<double> e = minus_a(b), f = minus_a(c), g = minus_a(d);
  const double yz = f.y * g.z, zy = f.z * g.y, zx = f.z * g.x, xz = f.x * g.z, xy = f.x * g.y, yx = f.y * g.x;
  const double determinant = e.x * (yz - zy) + e.y * (zx - xz) + e.z * (xy - yx);
  const double terms = std::abs(e.x) * (std::abs(yz) + std::abs(zy)) + std::abs(e.y) * (std::abs(zx) + std::abs(xz)) +
                       std::abs(e.z) * (std::abs(xy) + std::abs(yx));
  const double bound = (7 + 56 * u) * u * terms;  // Shewchuk's o3derrboundA
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  if (terms == 0) return 0;
  ExactSum sum;
  add_determinant(sum, b, c, d, 1), add_determinant(sum, a, c, d, -1);
  add_determinant(sum, a, b, d, 1), add_determinant(sum, a, b, c, -1);
  return sum.sign();
}

int orient2d(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (double(b.x) - a.x) * (double(c.y) - a.y), right = (double(b.y) - a.y) * (double(c.x) - a.x);
  const double determinant = left - right, terms = std::abs(left) + std::abs(right);
  const double bound = (3 + 16 * u) * u * terms;  // Shewchuk's ccwerrboundA
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  if (terms == 0) return 0;
  ExactSum sum;
  sum.add(double(b.x) * c.y), sum.add(-double(b.y) * c.x);
  sum.add(-double(a.x) * c.y), sum.add(double(a.y) * c.x);
  sum.add(double(a.x) * b.y), sum.add(-double(a.y) * b.x);
  return sum.sign();
}

}  // namespace lockstep::production_cloth
