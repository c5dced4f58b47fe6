// SPDX-License-Identifier: MIT
// Prints the parameters of all nodes: node|name|type in Python|default|low|high|description.
#include <iostream>

#include "seatrial_ros/mimic_node.hpp"
#include "seatrial_ros/settings.hpp"
#include "seatrial_ros/sim_settings.hpp"
#include "seatrial_ros/tracking_settings.hpp"

namespace {

namespace sr = seatrial::ros;

void print(const std::string& value) { std::cout << "str|" << value; }
void print(bool value) { std::cout << "bool|" << (value ? "true" : "false"); }
void print(double value) { std::cout << "float|" << value; }
void print(const std::vector<double>&) { std::cout << "list|"; }

template <class Given>
void print_all(const char* node) {
  Given settings;
  each_parameter(settings, [node](const sr::Parameter& p, const auto& value) {
    std::cout << node << '|' << p.name << '|';
    print(value);
    std::cout << '|' << p.low << '|' << p.high << '|' << p.description << '\n';
  });
}

}  // namespace

int main() {
  print_all<sr::Settings>("odometry");
  print_all<sr::SimSettings>("simulator");
  print_all<sr::MimicSettings>("mimic");
  print_all<sr::TrackingSettings>("tracking");
}
