// SPDX-License-Identifier: MIT
/// @file
/// @brief Sums of many doubles with the error of one rounding.
#pragma once

#include <cmath>

namespace slice2mesh::detail {

/// Sum with a running compensation (Neumaier): error of one rounding, whatever the number of terms.
class CompensatedSum {
public:
  void add(double value) {
    const double sum = sum_ + value;
    correction_ += std::fabs(sum_) >= std::fabs(value) ? (sum_ - sum) + value : (value - sum) + sum_;
    sum_ = sum;
  }
  void add(const CompensatedSum& other) {
    add(other.sum_);
    add(other.correction_);
  }
  [[nodiscard]] double value() const { return sum_ + correction_; }

private:
  double sum_ = 0;
  double correction_ = 0;
};

}  // namespace slice2mesh::detail
