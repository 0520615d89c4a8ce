// What nephele bake --verify writes beside the tables.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "lut/oracles.h"
#include "lut/study/verification.h"
#include "tests/support/support.h"

using namespace nephele;

TEST_CASE("verification measures a coarse bake, and the tables stay loadable with it") {
  const test::TempDirectory directory;
  TableParameters parameters;
  parameters.g_single = parameters.g_multiple = 0.5;
  parameters.optical_depth_size = 8;
  parameters.scattering_cosines = 16;
  parameters.scattering_chords = 8;
  parameters.scattering_densities = 8;
  parameters.coarse_solver = true;
  Result<Tables> tables = bake_to(directory / "tables", parameters);
  REQUIRE(tables);
  double shown = 0;
  const auto show = [&](const std::string&, double fraction) { shown = fraction; };
  verify_tables(*tables, show, 0.02);
  CHECK(shown == 1.0);
  REQUIRE(save_metadata(tables->optical_depth));
  REQUIRE(save_metadata(tables->multiple_scattering));

  const Result<Tables> loaded = load_tables(directory / "tables");
  if (!loaded) FAIL(loaded.error().message);
  const auto depth = nlohmann::json::parse(loaded->optical_depth.metadata).at("verification");
  CHECK(depth.at("transmittance_rms") > 0.03);  // eight vertices a side are few: the error must show
  CHECK(depth.at("transmittance_rms") < 0.3);
  REQUIRE(depth.at("other_axes").at("maps").size() == 3);
  for (const auto& map : depth["other_axes"]["maps"]) {
    CHECK(map.at("transmittance_rms") > 0.0);
    CHECK(map.at("transmittance_rms") < 0.15);
  }
  const auto sphere = nlohmann::json::parse(loaded->multiple_scattering.metadata).at("verification");
  for (const auto& row : sphere.at("single_scattering").at("rows")) CHECK(row.at("relative_rmse") < 0.03);
  // A coarse table is good to some percent; the Monte Carlo of a fiftieth of the paths sees a gross mistake.
  for (const auto& row : sphere.at("all_orders").at("rows")) {
    CAPTURE(row.dump());
    CHECK(row.at("relative_rmse") <= row.at("relative_rmse_at_most"));
    CHECK(std::abs(row.at("relative_bias").get<double>()) < 0.03 + 4 * row.at("relative_bias_noise").get<double>());
  }
  for (const auto& row : sphere.at("identities").at("rows")) {
    CHECK(std::abs(row.at("energy").get<double>()) < 0.05);
    CHECK(row.at("furnace") < 0.1);
  }
  for (const auto& row : sphere.at("power_per_order").at("rows")) {
    const double sum = row.at("direct").get<double>() + row.at("single").get<double>() +
                       row.at("orders_2_to_18").get<double>() + row.at("orders_over_18").get<double>();
    CHECK(sum == doctest::Approx(1.0));
    CHECK(std::abs(row.at("scatterings_over_4_3_optical_radius").get<double>() - 1) <
          4 * row.at("scatterings_standard_error").get<double>());
  }
}

TEST_CASE("power per order of thick spheres: eighteen orders leave half of the light inside") {
  // [Yusov14] sums 18 orders; at optical radius 103 they carry 0.45 of the power, those beyond 0.53.
  const OrderPowers powers = monte_carlo_orders({0, 0.7, 103}, 0.9, 20000, 1);
  const double error = 4 * 0.5 / std::sqrt(20000.0);
  CHECK(std::abs(powers.between(1, 1).mean - 0.020) < error);
  CHECK(std::abs(powers.between(2, 18).mean - 0.446) < error);
  CHECK(std::abs(powers.between(19, 1 << 20).mean - 0.534) < error);
}
