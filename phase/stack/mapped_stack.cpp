#include "phase/stack/mapped_stack.h"

#include <fmt/format.h>

#include <array>
#include <mutex>

#include "phase/stack/map_keys.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_reader.h"

namespace lamella {

struct MappedStack::Content {
  // Values stand in the file's own tables while a stack is read, which so keep their lines: copies
  // of tables have none.
  toml::table root;
  std::mutex reading;
  std::string file, name;
  std::vector<MappedKey> maps;
};

namespace {

// The table of a layer or of the substrate; nullptr where the file has none.
toml::table* part_of(toml::table& root, const MappedKey& key) {
  if (!key.layer) return root["substrate"].as_table();
  toml::array* layers = root["layer"].as_array();
  return layers && *key.layer < layers->size() ? layers->get(*key.layer)->as_table() : nullptr;
}

void find_maps(const KeyReader& keys, const toml::table& table, std::optional<std::size_t> layer,
               std::vector<MappedKey>& maps) {
  const std::string part = layer ? fmt::format("layer {}", *layer) : "substrate";
  for (const auto& [word, value] : table) {
    // Of its own, as clang's lambdas take no structured binding.
    const toml::node& node = value;
    // A name that is no file is refused by the reader of the words.
    if (!names_picture(node)) continue;
    MappedKey found{.layer = layer,
                    .key = std::string(word.str()),
                    .info = {},
                    .map = {},
                    .where = fmt::format("{}:{}: {}: key \"{}\"", keys.file(),
                                         node.source().begin.line, part, word.str())};
    found.map = read_map(keys, node, part, found.key);
    found.info = known_key(table, !layer, word.str());
    const bool is_direction = found.map.encoding != MapEncoding::value;
    const auto refuse = [&](const std::string& allowed) {
      keys.fail(
          node.source(),
          fmt::format("{}: key \"{}\": found the picture \"{}\"{}; allowed: {}", part, found.key,
                      found.map.file, is_direction ? " of directions" : "", allowed));
    };
    const bool word_only = !layer && !found.info
                               ? found.key == "bsdf"
                               : !found.info || found.info->kind == ParameterKind::choice ||
                                     found.info->kind == ParameterKind::matrix;
    if (word_only) {
      if (found.info) refuse(allowed_values(*found.info));
      continue;  // an unknown key: the reader knows which there are
    }
    const bool vector = found.info && found.info->kind == ParameterKind::vector;
    if (vector != is_direction && found.info)
      refuse(vector ? allowed_values(*found.info) +
                          ", or a picture with encoding = \"normal\" or \"angle\""
                    : allowed_values(*found.info) + ", or a picture with encoding = \"value\"");
    maps.push_back(std::move(found));
  }
}

template <class Array>
void insert_numbers(toml::table& table, const std::string& key, const Array& numbers) {
  toml::array list;
  for (const double x : numbers) list.push_back(x);
  table.insert_or_assign(key, std::move(list));
}

void insert(toml::table& table, const std::string& key, const ParameterValue& value) {
  if (const auto* number = std::get_if<double>(&value))
    table.insert_or_assign(key, *number);
  else if (const auto* color = std::get_if<Rgb>(&value))
    insert_numbers(table, key, std::array{color->r, color->g, color->b});
  else if (const auto* list = std::get_if<std::vector<double>>(&value))
    insert_numbers(table, key, *list);
  else
    table.insert_or_assign(key, std::get<std::string>(value));
}

}  // namespace

std::string MappedKey::path() const {
  return layer ? fmt::format("layer.{}.{}", *layer, key) : "substrate." + key;
}

MappedStack::MappedStack(std::string_view text, const std::string& file, std::string name)
    : content_(std::make_unique<Content>()) {
  content_->root = parse_toml(text, file);
  content_->file = file;
  content_->name = std::move(name);
  const KeyReader keys(file);
  if (const toml::array* layers = content_->root["layer"].as_array())
    for (std::size_t k = 0; k < layers->size(); ++k)
      if (const toml::table* table = layers->get(k)->as_table())
        find_maps(keys, *table, k, content_->maps);
  if (const toml::table* table = content_->root["substrate"].as_table())
    find_maps(keys, *table, std::nullopt, content_->maps);
}

MappedStack::MappedStack(MappedStack&&) noexcept = default;
MappedStack& MappedStack::operator=(MappedStack&&) noexcept = default;
MappedStack::~MappedStack() = default;

const std::string& MappedStack::name() const { return content_->name; }

const std::vector<MappedKey>& MappedStack::maps() const { return content_->maps; }

Stack MappedStack::with(const std::vector<ParameterValue>& values) const {
  if (maps().empty()) return plain();
  const std::lock_guard lock(content_->reading);
  toml::table& root = content_->root;
  for (std::size_t k = 0; k < maps().size(); ++k)
    insert(*part_of(root, maps()[k]), maps()[k].key, values.at(k));
  return read_stack(root, content_->file, name());
}

Stack MappedStack::plain() const {
  if (!maps().empty()) {
    const MappedKey& first = maps().front();
    throw StackFileError(fmt::format(
        "{}: found the picture \"{}\"; allowed: {} here, where the stack has to be the same at "
        "every place (--at U,V takes the stack of one place)",
        first.where, first.map.file,
        first.info ? allowed_values(*first.info) : "a number or a colour"));
  }
  return read_stack(content_->root, content_->file, name());
}

Stack parse_stack(std::string_view text, const std::string& file, std::string name) {
  return MappedStack(text, file, std::move(name)).plain();
}

}  // namespace lamella
