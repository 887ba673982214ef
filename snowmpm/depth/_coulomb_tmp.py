import taichi as ti


@ti.func
def stress(prm, density, sigma, speed, depth):
    return ti.Vector([prm[0] * sigma, density * prm[1] * speed])
