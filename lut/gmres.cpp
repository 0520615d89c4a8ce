#include "lut/gmres.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/parallel.h"

namespace nephele {

namespace {

constexpr int kBlock = 8192;  // elements a task sums: small enough for the cache, and the same whatever the cores

int blocks(std::size_t n) { return static_cast<int>((n + kBlock - 1) / kBlock); }

// Inner products of w with vectors[0 .. count).
std::vector<double> inner_products(const std::vector<std::vector<float>>& vectors, int count,
                                   const std::vector<float>& w) {
  const int parts = blocks(w.size());
  std::vector<double> partial(static_cast<std::size_t>(parts) * count);
  parallel_for(parts, [&](int part) {
    const std::size_t begin = static_cast<std::size_t>(part) * kBlock, end = std::min(w.size(), begin + kBlock);
    for (int v = 0; v < count; ++v) {
      const float* a = vectors[v].data();
      float lanes[16] = {};
      std::size_t i = begin;
      for (; i + 16 <= end; i += 16)
        for (int k = 0; k < 16; ++k) lanes[k] += a[i + k] * w[i + k];
      double sum = 0;
      for (; i < end; ++i) sum += static_cast<double>(a[i]) * w[i];
      for (float lane : lanes) sum += lane;
      partial[static_cast<std::size_t>(part) * count + v] = sum;
    }
  });
  std::vector<double> sums(count, 0.0);
  for (int part = 0; part < parts; ++part)
    for (int v = 0; v < count; ++v) sums[v] += partial[static_cast<std::size_t>(part) * count + v];
  return sums;
}

// w += sum of factors[v] * vectors[v].
void accumulate(const std::vector<std::vector<float>>& vectors, const std::vector<double>& factors,
                std::vector<float>& w) {
  parallel_for(blocks(w.size()), [&](int part) {
    const std::size_t begin = static_cast<std::size_t>(part) * kBlock, end = std::min(w.size(), begin + kBlock);
    for (std::size_t v = 0; v < factors.size(); ++v) {
      const float factor = static_cast<float>(factors[v]);
      const float* a = vectors[v].data();
      for (std::size_t i = begin; i < end; ++i) w[i] += factor * a[i];
    }
  });
}

double norm(const std::vector<float>& v) {
  double sum = 0;
  for (float x : v) sum += static_cast<double>(x) * x;
  return std::sqrt(sum);
}

void scale(std::vector<float>& v, double factor) {
  for (float& x : v) x = static_cast<float>(x * factor);
}

}  // namespace

GmresResult gmres(const std::function<void(const float*, float*)>& apply, const std::vector<float>& b, double tolerance,
                  int restart, int max_applications) {
  const std::size_t n = b.size();
  const double target = tolerance * norm(b);
  GmresResult result;
  result.x.assign(n, 0.0f);
  if (target == 0) return result;
  std::vector<float> residual = b, image(n);
  double beta = norm(residual);
  while (beta > target && result.applications < max_applications) {
    // One cycle of Arnoldi; the triangular factor of the Hessenberg matrix is kept up by Givens rotations.
    std::vector<std::vector<float>> basis;
    std::vector<std::vector<double>> columns;
    std::vector<double> cosines, sines, rhs{beta};
    scale(residual, 1 / beta);
    basis.push_back(std::move(residual));
    while (static_cast<int>(columns.size()) < restart && result.applications < max_applications) {
      const int k = static_cast<int>(columns.size());
      apply(basis[k].data(), image.data());
      ++result.applications;
      std::vector<float> w(n);
      for (std::size_t i = 0; i < n; ++i) w[i] = basis[k][i] - image[i];
      std::vector<double> column(k + 2, 0.0);
      for (int pass = 0; pass < 2; ++pass) {  // classical Gram-Schmidt, twice: as stable as the modified one
        std::vector<double> h = inner_products(basis, k + 1, w);
        for (int i = 0; i <= k; ++i) {
          column[i] += h[i];
          h[i] = -h[i];
        }
        accumulate(basis, h, w);
      }
      column[k + 1] = norm(w);
      const double subdiagonal = column[k + 1];
      for (int i = 0; i < k; ++i) {
        const double rotated = cosines[i] * column[i] + sines[i] * column[i + 1];
        column[i + 1] = -sines[i] * column[i] + cosines[i] * column[i + 1];
        column[i] = rotated;
      }
      const double length = std::hypot(column[k], column[k + 1]);
      cosines.push_back(column[k] / length);
      sines.push_back(column[k + 1] / length);
      column[k] = length;
      rhs.push_back(-sines[k] * rhs[k]);
      rhs[k] *= cosines[k];
      columns.push_back(std::move(column));
      if (std::abs(rhs[k + 1]) <= target || subdiagonal <= 1e-12 * beta) break;
      scale(w, 1 / subdiagonal);
      basis.push_back(std::move(w));
    }
    const int k = static_cast<int>(columns.size());
    std::vector<double> y(k);
    for (int i = k - 1; i >= 0; --i) {
      double sum = rhs[i];
      for (int j = i + 1; j < k; ++j) sum -= columns[j][i] * y[j];
      y[i] = sum / columns[i][i];
    }
    basis.resize(k);
    accumulate(basis, y, result.x);
    if (std::abs(rhs[k]) <= target) {
      beta = std::abs(rhs[k]);
      break;
    }
    apply(result.x.data(), image.data());
    ++result.applications;
    residual.assign(n, 0.0f);
    for (std::size_t i = 0; i < n; ++i) residual[i] = b[i] - result.x[i] + image[i];
    beta = norm(residual);
  }
  result.residual = beta / norm(b);
  return result;
}

}  // namespace nephele
