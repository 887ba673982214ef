"""What a sample of snow is made of: ice and pores of a voxel image, and what follows from them."""
