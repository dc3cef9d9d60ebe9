#include "compare/shards/job_array.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "compare/request/errors.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

using ::testing::HasSubstr;
using Variables = std::map<std::string, std::string>;

Shard found(const std::string& text, const Variables& variables) {
  return shard_from(text, [&](const std::string& name) -> std::optional<std::string> {
    const auto it = variables.find(name);
    if (it == variables.end()) return std::nullopt;
    return it->second;
  });
}

std::string refused(const std::string& text, const Variables& variables) {
  const std::string message = message_of<UsageError>([&] { (void)found(text, variables); });
  EXPECT_THAT(message, HasSubstr("--shard"));
  EXPECT_THAT(message, HasSubstr("allowed: "));
  return message;
}

Variables slurm(const char* id, const char* min, const char* max, const char* step,
                const char* count) {
  return {{"SLURM_ARRAY_TASK_ID", id},
          {"SLURM_ARRAY_TASK_MIN", min},
          {"SLURM_ARRAY_TASK_MAX", max},
          {"SLURM_ARRAY_TASK_STEP", step},
          {"SLURM_ARRAY_TASK_COUNT", count}};
}

TEST(JobArray, OfSlurmTellsPartAndCount) {
  EXPECT_EQ(found("auto", slurm("1", "1", "16", "1", "16")), (Shard{1, 16}));
  EXPECT_EQ(found("auto", slurm("0", "0", "15", "1", "16")), (Shard{1, 16}));
  EXPECT_EQ(found("auto", slurm("15", "0", "15", "1", "16")), (Shard{16, 16}));
  EXPECT_EQ(found("auto", slurm("9", "5", "13", "4", "3")), (Shard{2, 3}));
  // One task that runs again.
  EXPECT_EQ(found("auto/16", slurm("7", "7", "7", "1", "1")), (Shard{7, 16}));
  EXPECT_EQ(found("2/4", slurm("7", "7", "7", "1", "1")), (Shard{2, 4}));
}

TEST(JobArray, OfSlurmIsRefusedWhereItsVariablesContradict) {
  EXPECT_THAT(refused("auto", slurm("3", "1", "7", "1", "3")), HasSubstr("TASK_COUNT = 3"));
  EXPECT_THAT(refused("auto", slurm("9", "1", "7", "1", "7")), HasSubstr("TASK_ID = 9"));
  EXPECT_THAT(refused("auto", slurm("6", "5", "13", "4", "3")), HasSubstr("steps of 4"));
  EXPECT_THAT(refused("auto", slurm("1", "7", "1", "1", "7")), HasSubstr("from 7 to 1"));
  EXPECT_THAT(refused("auto", slurm("1", "1", "7", "0", "7")), HasSubstr("steps of 0"));
  EXPECT_THAT(refused("auto", slurm("x", "1", "7", "1", "7")), HasSubstr("= \"x\""));
  EXPECT_THAT(refused("auto", slurm("-1", "1", "7", "1", "7")), HasSubstr("= \"-1\""));
  EXPECT_THAT(refused("auto", slurm("99999999999999999999", "1", "7", "1", "7")),
              HasSubstr("whole number"));
  EXPECT_THAT(refused("auto", slurm("1", "1", "2000000", "1", "2000000")), HasSubstr("up to"));
  EXPECT_THAT(refused("auto", {{"SLURM_ARRAY_TASK_ID", "1"}}), HasSubstr("auto/N"));
  EXPECT_THAT(refused("auto/16", slurm("17", "1", "17", "1", "17")), HasSubstr("from 1 to 16"));
  EXPECT_THAT(refused("auto/16", slurm("0", "0", "15", "1", "16")), HasSubstr("from 1 to 16"));
}

TEST(JobArray, OfGridEngineTellsPartAndCount) {
  const Variables third{{"SGE_TASK_ID", "5"},
                        {"SGE_TASK_FIRST", "1"},
                        {"SGE_TASK_LAST", "8"},
                        {"SGE_TASK_STEPSIZE", "2"}};
  EXPECT_EQ(found("auto", third), (Shard{3, 4}));
  // No array.
  EXPECT_THAT(refused("auto", {{"SGE_TASK_ID", "undefined"}, {"SGE_TASK_FIRST", "undefined"}}),
              HasSubstr("no task"));
}

TEST(JobArray, OfPbsAndKubernetesNeedsTheCount) {
  EXPECT_EQ(found("auto/8", {{"PBS_ARRAY_INDEX", "8"}}), (Shard{8, 8}));
  EXPECT_EQ(found("auto/8", {{"PBS_ARRAYID", "1"}}), (Shard{1, 8}));
  EXPECT_EQ(found("auto/8", {{"JOB_COMPLETION_INDEX", "0"}}), (Shard{1, 8}));
  EXPECT_EQ(found("auto/8", {{"JOB_COMPLETION_INDEX", "7"}}), (Shard{8, 8}));
  EXPECT_THAT(refused("auto", {{"PBS_ARRAY_INDEX", "3"}}), HasSubstr("auto/N"));
  EXPECT_THAT(refused("auto", {{"JOB_COMPLETION_INDEX", "3"}}), HasSubstr("auto/N"));
  EXPECT_THAT(refused("auto/8", {{"PBS_ARRAY_INDEX", "0"}}), HasSubstr("from 1 to 8"));
  EXPECT_THAT(refused("auto/8", {{"JOB_COMPLETION_INDEX", "8"}}), HasSubstr("from 0 to 7"));
}

TEST(JobArray, OfNoneOrTwoSchedulersIsRefused) {
  EXPECT_THAT(refused("auto", {}), HasSubstr("no task of a job array"));
  EXPECT_THAT(refused("auto/4", {{"PBS_ARRAY_INDEX", "1"}, {"SLURM_ARRAY_TASK_ID", "1"}}),
              HasSubstr("beside"));
  for (const char* text :
       {"auto/", "auto/0", "auto/x", "auto/1/2", "auto/1000001", "autos", "AUTO"})
    EXPECT_THAT(refused(text, {{"PBS_ARRAY_INDEX", "1"}}), HasSubstr("found"));
}

}  // namespace
}  // namespace lamella
