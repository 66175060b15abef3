#pragma once

/// Rates as text: simulated seconds per second of real time.

#include <QString>
#include <QStringList>
#include <optional>

namespace flatland_viz {

/// The rates that are offered.
QStringList CommonRates();

/// "0.5", or "as fast as possible" for infinity.
QString FormatRate(double rate);

/// Nothing if the text is no rate. Whether the server accepts the rate is for the server to say.
std::optional<double> ParseRate(const QString& text);

}  // namespace flatland_viz
