#pragma once

/// Rates as strings: simulated seconds per second of real time.

#include <QString>
#include <QStringList>
#include <optional>

namespace flatland_viz {

/// The rates to choose from.
QStringList CommonRates();

/// "0.5", or "as fast as possible" for infinity.
QString FormatRate(double rate);

/// The rate, which the server may still refuse; nothing if the string is not a number.
std::optional<double> ParseRate(const QString& text);

}  // namespace flatland_viz
