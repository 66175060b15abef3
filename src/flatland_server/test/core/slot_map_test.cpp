#include "base/slot_map.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace flatland {
namespace {

using Names = SlotMap<std::string>;

TEST(SlotMap, DefaultHandleNamesNothing) {
  Names names("robot");
  const Handle<std::string> nothing;
  EXPECT_FALSE(names.Contains(nothing));

  names.Add("Anna");

  EXPECT_FALSE(names.Contains(nothing));
  EXPECT_THROW(names.Get(nothing), GoneError);
}

TEST(SlotMap, RemovedHandleIsGoneAlsoAfterItsSlotIsReused) {
  Names names("robot");
  const Handle<std::string> anna = names.Add("Anna");
  names.Remove(anna);

  const Handle<std::string> bert = names.Add("Bert");

  ASSERT_EQ(bert.index, anna.index);
  EXPECT_THROW(names.Get(anna), GoneError);
  EXPECT_THROW(names.Remove(anna), GoneError);
  EXPECT_EQ(names.Get(bert), "Bert");
}

TEST(SlotMap, RemovingDestroysTheValue) {
  SlotMap<std::shared_ptr<int>> numbers("number");
  const auto number = std::make_shared<int>(7);
  const Handle<std::shared_ptr<int>> handle = numbers.Add(number);

  numbers.Remove(handle);

  EXPECT_EQ(number.use_count(), 1);
}

TEST(SlotMap, ForEachVisitsWhatIsThereInTheOrderOfAddingAlsoWhenSlotsAreReused) {
  Names names("robot");
  const Handle<std::string> anna = names.Add("Anna");
  const Handle<std::string> bert = names.Add("Bert");
  names.Add("Cleo");
  names.Remove(anna);
  names.Remove(bert);
  names.Add("Dora");
  const Handle<std::string> emil = names.Add("Emil");
  ASSERT_EQ(emil.index, anna.index);

  std::string visited;
  names.ForEach([&](Handle<std::string> handle, const std::string& name) {
    visited += name + " ";
    EXPECT_EQ(names.Get(handle), name);
  });

  EXPECT_EQ(visited, "Cleo Dora Emil ");
}

TEST(SlotMap, TheVisitedOneMayBeRemoved) {
  Names names("robot");
  for (const char* name : {"Anna", "Bert", "Cleo"}) names.Add(name);

  int visits = 0;
  names.ForEach([&](Handle<std::string> handle, const std::string&) {
    ++visits;
    names.Remove(handle);
  });

  EXPECT_EQ(visits, 3);
  names.ForEach([](Handle<std::string>, const std::string& name) { ADD_FAILURE() << name; });
}

}  // namespace
}  // namespace flatland
