// The rows of a figure's report, as they come. Rows of other shards are left out. Rows that an earlier run left are not
// measured again.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

#include "verify/report.h"

namespace lockstep::verify {

using Rows = nlohmann::ordered_json;

class RowsOf {
 public:
  RowsOf(Report& report, const std::optional<Shard>& shard) : report_(report), shard_(shard) {}

  // A row of these fields and of the values that `measure` returns, unless an earlier run left it.
  void add(Rows fields, const std::function<Rows()>& measure) {
    const std::size_t place = places_++;
    if (!in_share(shard_, place)) return;
    const Rows earlier = report_.take_earlier(fields);
    if (earlier.empty()) fields.update(measure());
    put(earlier.empty() ? std::move(fields) : earlier[0], place);
    Rows all = rows_;
    all.insert(all.end(), report_.earlier().begin(), report_.earlier().end());
    report_.keep(all);
  }
  void add(Rows row) {  // one that takes no time
    const std::size_t place = places_++;
    if (in_share(shard_, place)) put(std::move(row), place);
  }
  void finish() { report_.finish(rows_); }

 private:
  void put(Rows row, std::size_t place) {
    report_.put_place(row, place);
    rows_.push_back(std::move(row));
  }

  Report& report_;
  const std::optional<Shard> shard_;
  std::size_t places_ = 0;  // of rows, those of other shards among them
  Rows rows_ = Rows::array();
};

}  // namespace lockstep::verify
