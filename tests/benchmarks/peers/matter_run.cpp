// A problem solved by matter (github.com/larsblatny/matter, GPL-3.0), compiled with its sources by matter_code.py.
//
//     run bar CELLS FLIP_RATIO PERIOD       the free bar of free_bar.py
//     run sand DX FLIP_RATIO TIME           the sand of sand_slice.py
//
// Reads lines of position and velocity (2 or 3 numbers each) from standard input. Writes the number of particles, the
// processor seconds of all steps, and position and velocity along x of each particle at the end.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <vector>

#include "simulation/simulation.hpp"

// Output of files, which this has no use for; so that the header of PLY files is not needed.
void Simulation::saveInfo() {}
void Simulation::saveTiming() {}
void Simulation::saveAvgData() {}
void Simulation::saveParticleData(std::string) {}
void Simulation::saveGridData(std::string) {}

static void elastic(Simulation &sim) {
  sim.nu = 0.0;
  sim.plastic_model = PlasticModel::NoPlasticity;
}

static void sand(Simulation &sim) {
  const double slope = 10.0 * M_PI / 180.0;
  sim.nu = 0.3;
  sim.gravity = TV::Zero();
  sim.gravity[0] = 9.81 * std::sin(slope);
  sim.gravity[1] = -9.81 * std::cos(slope);
  sim.plastic_model = PlasticModel::DPSoft;
  sim.use_pradhana = true;
  sim.xi = 0.0;
  sim.q_cohesion = 0.0;
  sim.M = std::tan(30.0 * M_PI / 180.0);
  sim.plates.push_back(std::make_unique<ObjectPlate>(0.0, PlateType::left, BC::SlipFree));
  sim.plates.push_back(std::make_unique<ObjectPlate>(0.0, PlateType::bottom, BC::NoSlip));
#ifdef THREEDIM
  sim.plates.push_back(std::make_unique<ObjectPlate>(0.0, PlateType::back, BC::SlipFree));
  sim.plates.push_back(std::make_unique<ObjectPlate>(4.0 * sim.dx, PlateType::front, BC::SlipFree));
#endif
}

int main(int, char **argv) {
  const bool is_bar = std::string(argv[1]) == "bar";
  std::vector<TV> x, v;
  double number;
  while (std::cin >> number) {
    TV place, speed;
    place[0] = number;
    for (int d = 1; d < DIMENSION; d++) std::cin >> place[d];
    for (int d = 0; d < DIMENSION; d++) std::cin >> speed[d];
    x.push_back(place);
    v.push_back(speed);
  }

  Simulation sim;
  sim.initialize(false);
  sim.reduce_verbose = true;
  sim.n_threads = 1;
  sim.end_frame = 1;
  sim.flip_ratio = std::atof(argv[3]);
  sim.fps = 1.0 / std::atof(argv[4]);
  sim.dx = is_bar ? 1.0 / std::atof(argv[2]) : std::atof(argv[2]);
  sim.E = 1e6;
  sim.rho = 1000.0;
  sim.elastic_model = ElasticModel::Hencky;
  sim.grid_reference_point = TV::Zero();
  is_bar ? elastic(sim) : sand(sim);
  sim.Np = x.size();
  sim.particles = Particles(sim.Np);
  sim.particles.x = x;
  sim.particles.v = v;
  sim.particle_volume = std::pow(0.5 * sim.dx, DIMENSION);
  sim.particle_mass = sim.rho * sim.particle_volume;

  const std::clock_t begun = std::clock();
  sim.simulate();
  const double seconds = double(std::clock() - begun) / CLOCKS_PER_SEC;

  std::printf("FOUND %zu %.6g\n", x.size(), seconds);
  for (size_t p = 0; p < x.size(); p++)
    std::printf("%.12g %.12g\n", double(sim.particles.x[p][0]), double(sim.particles.v[p][0]));
}
