#pragma once

namespace lamella {

// Words of a lattice's step (phase/random/lattice.h) in walks through grids: the flight, four of
// the event, the acceptance of a first tentative collision, and on lanes the roulette; next-event
// estimation has words of its own. Step 0 begins the walk: its event is the place in the tile.
inline constexpr int kFlightWord = 0, kEventWord = 1, kAcceptanceWord = 5, kGridRouletteWord = 7;

}  // namespace lamella
