#include "compare/request/csv_reader.h"

#include <gmock/gmock.h>

#include <sstream>

#include "compare/request/direction_pairs.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> fields_of(const std::string& text) {
  std::istringstream in(text);
  CsvReader reader(in, "p.csv");
  const auto fields = reader.next();
  return fields ? *fields : std::vector<std::string>{};
}

TEST(CsvReader, TrimsFieldsAtTheirEndsAndLeavesBlanksInside) {
  EXPECT_THAT(fields_of(" a ,b c,\t d\r\n"), ElementsAre("a", "b c", "d"));
  EXPECT_THAT(fields_of("a,,\n"), ElementsAre("a", "", ""));
  EXPECT_THAT(fields_of("\n  \n\xef\xbb\xbf"), ElementsAre("\xef\xbb\xbf"));  // a mark begins files
  EXPECT_THAT(fields_of("\xef\xbb\xbf"
                        "a,b"),
              ElementsAre("a", "b"));
}

TEST(CsvReader, TakesQuotedFields) {
  EXPECT_THAT(fields_of("\"a\", \"b \"\"c\"\", d\" ,e\n"), ElementsAre("a", "b \"c\", d", "e"));
  EXPECT_THAT(fields_of("\"\",\"a\"\n"), ElementsAre("", "a"));
}

TEST(CsvReader, FindsWhatSeparatesFields) {
  EXPECT_THAT(fields_of("a;b;c,d\n"), ElementsAre("a", "b", "c,d"));
  EXPECT_THAT(fields_of("a\tb c\n"), ElementsAre("a", "b c"));
  EXPECT_THAT(fields_of("sep=;\na;b\n"), ElementsAre("a", "b"));
}

std::string refusal_of(const std::string& text) {
  return message_of<std::runtime_error>([&] {
    std::istringstream in(text);
    (void)read_pairs(in, "p.csv");
  });
}

DirectionPairs pairs_of(const std::string& text) {
  std::istringstream in(text);
  return read_pairs(in, "p.csv");
}

TEST(DirectionPairs, AreNumbersOfWholeFields) {
  const DirectionPairs pairs = pairs_of("mu_i,phi_i,mu_o,phi_o\n 0.5 ,\t45, +0.25,-1e1\n");
  ASSERT_EQ(pairs.rows.size(), 1U);
  EXPECT_EQ(pairs.rows[0], "0.5,45,+0.25,-1e1");
  EXPECT_EQ(pairs.lines[0], 2);
  EXPECT_DOUBLE_EQ(pairs.pairs[0].wi.z, 0.5);
  EXPECT_DOUBLE_EQ(pairs.pairs[0].wo.z, 0.25);
}

TEST(DirectionPairs, OfSpreadsheetsAreThoseOfPlainFiles) {
  const std::string header = "theta_i,phi_i,theta_o,phi_o";
  const std::string plain = header + "\n10.5,0,20,90\n";
  for (const std::string& text :
       {// R: write.csv(row.names = FALSE); Excel in Germany; tabs; a byte order mark, CRLF.
        std::string("\"theta_i\",\"phi_i\",\"theta_o\",\"phi_o\"\n10.5,0,20,90\n"),
        std::string("theta_i;phi_i;theta_o;phi_o\r\n10,5;0;20;90\r\n\r\n"),
        std::string("\"theta_i\";\"phi_i\";\"theta_o\";\"phi_o\"\n\"10,5\";\"0\";\"20\";\"90\"\n"),
        std::string("theta_i\tphi_i\ttheta_o\tphi_o\n10.5\t0\t20\t90"),
        std::string("\xef\xbb\xbf"
                    "theta_i,phi_i,theta_o,phi_o\r\n10.5,0,20,90\r\n")}) {
    SCOPED_TRACE(text);
    const DirectionPairs pairs = pairs_of(text), right = pairs_of(plain);
    EXPECT_EQ(pairs.header, header);
    ASSERT_EQ(pairs.rows, right.rows);
    EXPECT_EQ(pairs.pairs[0].wi, right.pairs[0].wi);
    EXPECT_EQ(pairs.pairs[0].wo, right.pairs[0].wo);
  }
}

TEST(DirectionPairs, ThatAreNotUnderstoodAreRefusedWithTheirLine) {
  const std::string mu = "mu_i,phi_i,mu_o,phi_o\n";
  const std::string semicolons = "mu_i;phi_i;mu_o;phi_o\n";
  struct Case {
    std::string text;
    std::vector<std::string> parts;
  };
  for (const Case& c : std::vector<Case>{
           {mu + "0.5,0 45,1,0\n", {"p.csv:2:", "\"0.5,0 45,1,0\"", "phi_i \"0 45\""}},
           {mu + "0.5 0 1 0\n", {"p.csv:2:", "\"0.5 0 1 0\"", "1 field;", "four numbers"}},
           {mu + "0,5,0,1,0\n", {"p.csv:2:", "5 fields"}},
           {mu + "\"0,5\",0,1,0\n", {"p.csv:2:", "mu_i \"0,5\""}},
           {mu + "0.5,0,1,\n", {"p.csv:2:", "phi_o \"\""}},
           {mu + "\n\n0.5,0,1\n", {"p.csv:4:", "3 fields"}},
           {mu + "0.5,0,1,+-5\n", {"\"+-5\""}},
           {mu + "0.5,0,1,0x10\n", {"\"0x10\""}},
           {mu + "0.5,0,1,1e999\n", {"\"1e999\""}},
           {mu + "\"0.5,0,1,0\n", {"a quote without its end"}},
           {mu + "\"0.5\"1,0,1,0\n", {"text beside a quoted field"}},
           {mu + std::string("0.5,0,1,0\0\n", 11), {"a zero byte"}},
           {semicolons + "0,5;0;1;0.5\n", {"p.csv:2:", "phi_o \"0.5\""}},
           {semicolons + "1.234,5;0;1;0\n", {"mu_i \"1.234,5\""}},
           {semicolons + "0.5,0,1,0\n", {"1 field;"}},
           {"\"\",\"mu_i\",\"phi_i\",\"mu_o\",\"phi_o\"\n", {"p.csv:1:", "5 columns"}},
           {"mu_i phi_i mu_o phi_o\n", {"p.csv:1:", "1 column;", "mu_i,phi_i,mu_o,phi_o"}},
           {std::string("\xff\xfem\0u\0", 6), {"p.csv:1:", "UTF-16"}},
           {"mu_i,phi_i,mu_o,phi_o\r0.5,0,1,0\r", {"p.csv:1:", "\\x0d"}},
           {mu + std::string(100000, '1'), {"p.csv:2:", "more than 4096 bytes"}},
           {"", {"p.csv:1:", "empty"}}}) {
    SCOPED_TRACE(c.text.substr(0, 100));
    const std::string message = refusal_of(c.text);
    for (const std::string& part : c.parts) EXPECT_THAT(message, HasSubstr(part));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_LT(message.size(), 400U);
  }
}

}  // namespace
}  // namespace lamella
