#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "compare/reproduce/map_sheet.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/reproduction_list.h"
#include "compare/reproduce/reproduction_page.h"
#include "compare/reproduce/uniform_light.h"
#include "compare/request/model_request.h"

namespace lamella {
namespace {

ReproductionContext quiet() {
  return {.seed = 1, .stop = nullptr, .table = nullptr, .folder = "", .formats = {}, .walks = 1};
}

TEST(Reproductions, HaveNamesOfTheirOwnAndAreFoundByThem) {
  std::set<std::string> names;
  for (const Reproduction& r : reproductions()) {
    EXPECT_TRUE(names.insert(r.name).second) << r.name;
    EXPECT_EQ(find_reproduction(r.name), &r);
    EXPECT_GE(r.walks_of(Quality::draft), 1U);
    EXPECT_LE(r.walks_of(Quality::draft), r.walks_of(Quality::quick));
    EXPECT_LE(r.walks_of(Quality::quick), r.walks_of(Quality::final));
  }
  EXPECT_GE(names.size(), 40U);
  EXPECT_EQ(find_reproduction("nonsense"), nullptr);
}

TEST(Reproductions, HaveEveryFigureThatTheyMakeByItsNumber) {
  const std::pair<const char*, std::vector<int>> papers[] = {
      {"vmf", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}},
      {"lambert_sphere", {1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}},
      {"eon", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13}},
      {"micrograin", {4, 5, 9, 10, 11, 12, 13, 14}},
      {"spongecake", {1, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22}}};
  for (const auto& [paper, figures] : papers)
    for (const int k : figures)
      EXPECT_NE(find_reproduction(std::string(paper) + "_figure_" + std::to_string(k)), nullptr)
          << paper << ' ' << k;
}

TEST(Reproductions, EndWhereTheyAreStopped) {
  StopFlag stop{false};
  ReproductionContext context = quiet();
  context.go_on();
  context.stop = &stop;
  context.go_on();
  stop = true;
  EXPECT_THROW(context.go_on(), FigureStopped);
}

TEST(Reproductions, KeepFindingsAsTheyAreTold) {
  ReproductionContext context = quiet();
  context.find("a", "b", true);
  context.find("c", "d", false);
  ASSERT_EQ(context.findings.size(), 2U);
  EXPECT_TRUE(context.findings[0].agrees);
  EXPECT_EQ(context.findings[1].paper, "c");
  EXPECT_FALSE(context.findings[1].agrees);
  EXPECT_THROW((void)quality_from_text("best"), std::invalid_argument);
}

TEST(NumberRows, KeepNumbersAndTextsAndRefuseOtherCounts) {
  const ReproductionContext context = quiet();
  NumberRows rows(context, {{"x", ".2f"}, {"name"}});
  rows.add({1.25, "one"});
  rows.add({std::nan(""), "none"});
  EXPECT_THROW(rows.add({1.0}), std::invalid_argument);
  ASSERT_EQ(rows.rows().size(), 2U);
  EXPECT_EQ(rows.rows()[0]["x"], 1.25);
  EXPECT_EQ(rows.rows()[0]["name"], "one");
  EXPECT_TRUE(rows.rows()[1]["x"].is_null());
  // Who reads a table tells its columns by their titles; errors stand beside their values.
  EXPECT_THROW(NumberRows(context, {{"x"}, {"y", "g", "x"}}), std::invalid_argument);
  EXPECT_NO_THROW(NumberRows(context, {{"x"}, {"a", "g", "+-"}, {"y"}, {"b", "g", "+-"}}));
}

TEST(NumberRows, KeepNegativeNumbersApart) {
  char* text = nullptr;
  std::size_t size = 0;
  ReproductionContext context = quiet();
  context.table = open_memstream(&text, &size);
  NumberRows(context, {{"x", ".6f"}, {"y", ".6f"}, {"z", ".3e"}, {"u", ".1f"}})
      .add({-0.5, -0.25, -0.125, -1.0});
  std::fclose(context.table);
  const std::string said(text, size);
  std::free(text);
  EXPECT_EQ(said, "-0.500000 -0.250000 -1.250e-01     -1.0\n");
}

TEST(MapSheet, RefusesMapsOfTheWrongNumberOrSize) {
  MapSheet sheet{.title = "t",
                 .subtitle = "",
                 .columns = {"a", "b"},
                 .rows = {{.label = "r", .maps = {{1, 2, 3, 4}}}},
                 .side = 2};
  EXPECT_THROW((void)draw_map_sheet(sheet), std::invalid_argument);
  sheet.rows[0].maps.push_back({1, 2, 3});
  EXPECT_THROW((void)draw_map_sheet(sheet), std::invalid_argument);
}

TEST(ReproductionPage, EscapesTextsAndShowsWhatDoesNotAgree) {
  const nlohmann::ordered_json answer{
      {"version", "1"},
      {"quality", "draft"},
      {"seed", 1},
      {"reproductions",
       {{{"name", "one"},
         {"doc", "a < b & c"},
         {"source", "s"},
         {"rows", {{{"x", 1.5}, {"t", "<i>"}}}},
         {"findings", {{{"paper", "p"}, {"here", "h"}, {"agrees", false}}}},
         {"pictures", {"a.png"}},
         {"seconds", 1.0}},
        {{"name", "two"}, {"doc", "d"}, {"source", "s"}, {"left_out", "no Embree"}}}}};
  const std::string page = reproduction_page(answer);
  EXPECT_THAT(page, testing::HasSubstr("a &lt; b &amp; c"));
  EXPECT_THAT(page, testing::HasSubstr("&lt;i&gt;"));
  EXPECT_THAT(page, testing::Not(testing::HasSubstr("<i>")));
  EXPECT_THAT(page, testing::HasSubstr("0 of 1 agree"));
  EXPECT_THAT(page, testing::HasSubstr("does not agree"));
  EXPECT_THAT(page, testing::HasSubstr("src=\"one/a.png\""));
  EXPECT_THAT(page, testing::HasSubstr("Left out: no Embree"));
}

TEST(UniformLight, IsReflectedByTheClosedFormsAlbedo) {
  const auto model = [](const std::string& request) {
    return bind_model(parse_model_request(request), nullptr);
  };
  // EON's albedo is in closed form; 24 azimuths and 16 cosines leave some 1e-3 of its peak.
  const BoundModel eon = model("eon,albedo=0.8,roughness=0.7");
  for (const double mu : {0.2, 0.5, 1.0})
    EXPECT_NEAR(quick_albedo(*eon.model, mu).g, eon.model->albedo(direction_from_mu_phi(mu, 0)).g,
                3e-3)
        << mu;
  EXPECT_NEAR(quick_average_albedo(*model("lambert,albedo=0.4").model).g, 0.4, 1e-12);
  const BoundModel matched = model(with_bond_albedo("fon,roughness=1", Rgb(0.2, 0.3, 0.4)));
  const Rgb reflected = quick_average_albedo(*matched.model);
  EXPECT_NEAR(reflected.r, 0.2, 1e-3);
  EXPECT_NEAR(reflected.b, 0.4, 1e-3);
}

}  // namespace
}  // namespace lamella
