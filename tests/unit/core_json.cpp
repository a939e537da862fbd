#include "core/json.h"

#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace etendue {
namespace {

TEST(Json, ListsAreArraysUnlessTheyNameMembers) {
  EXPECT_EQ(Json({1, 2}).dump(), "[1,2]");
  EXPECT_EQ(Json({"a", "b"}).dump(), R"(["a","b"])");
  EXPECT_EQ(Json({{"b", 1}, {"a", {1, 2}}}).dump(), R"({"a":[1,2],"b":1})");
  EXPECT_EQ(Json({{"a", 1}, {2, 3}}).dump(), R"([["a",1],[2,3]])");
  EXPECT_EQ(Json::array().dump(), "[]");
  EXPECT_EQ(Json::object().dump(), "{}");
  EXPECT_EQ(Json().dump(), "null");
}

TEST(Json, ContainersBecomeArraysAndObjects) {
  EXPECT_EQ(Json(std::vector<std::string>{"x", "y"}).dump(), R"(["x","y"])");
  EXPECT_EQ(Json(std::array<float, 2>{0.5f, 2.0f}).dump(), "[0.5,2.0]");
  EXPECT_EQ(Json(std::map<std::string, std::string>{{"k", "v"}}).dump(), R"({"k":"v"})");
}

TEST(Json, NumbersReadBackAsTheyWere) {
  const std::uint64_t large = std::numeric_limits<std::uint64_t>::max();
  const std::int64_t small = std::numeric_limits<std::int64_t>::min();
  const double tenth = std::nextafter(0.1, 1.0);
  const auto read = nlohmann::json::parse(Json({{"large", large}, {"small", small}, {"tenth", tenth}}).dump());
  EXPECT_EQ(read["large"].get<std::uint64_t>(), large);
  EXPECT_EQ(read["small"].get<std::int64_t>(), small);
  EXPECT_EQ(read["tenth"].get<double>(), tenth);
  EXPECT_EQ(Json({std::nan(""), std::numeric_limits<double>::infinity(), true}).dump(), "[null,null,true]");
}

TEST(Json, EveryNameIsValid) {
  const std::string name = "\xff\"\\\n\x01é";
  const auto read = nlohmann::json::parse(Json({{name, name}}).dump(2));
  EXPECT_EQ(read.begin().key(), "\ufffd\"\\\n\x01é");
  EXPECT_EQ(read.begin().value(), "\ufffd\"\\\n\x01é");
}

TEST(Json, MembersAndElementsAreAdded) {
  Json out;
  out["list"].push_back({1, 2});
  out["list"].push_back("end");
  out["inner"]["x"] = nullptr;
  EXPECT_EQ(out.dump(), R"({"inner":{"x":null},"list":[[1,2],"end"]})");
  EXPECT_TRUE(out.contains("list"));
  EXPECT_FALSE(out.contains("lists"));
  EXPECT_THROW(out.push_back(1), std::bad_variant_access);
  EXPECT_THROW(out["list"]["name"], std::bad_variant_access);
}

}  // namespace
}  // namespace etendue
