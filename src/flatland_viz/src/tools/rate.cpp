#include "rate.hpp"

#include <cmath>
#include <limits>

namespace flatland_viz {
namespace {

const char* const kInfinity = "as fast as possible";

}  // namespace

QStringList CommonRates() { return {"0.1", "0.5", "1", "2", "5", "10", kInfinity}; }

QString FormatRate(double rate) { return std::isinf(rate) ? kInfinity : QString::number(rate); }

std::optional<double> ParseRate(const QString& text) {
  if (text.trimmed() == kInfinity) return std::numeric_limits<double>::infinity();
  bool is_number = false;
  const double rate = text.trimmed().toDouble(&is_number);
  if (!is_number) return std::nullopt;
  return rate;
}

}  // namespace flatland_viz
