//! Dresses a network: pavements, parked places, houses, hedges, trees, lamps; a function of network and seed.
