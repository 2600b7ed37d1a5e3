# The lecture's figures, one rule per slide. Each recipe documents its figure: what is run, on which scene, and what to
# look for.
#
#   make figures [QUALITY=quick|full] [FIGURES_OUT=out/figures]     all of them, and out/figures/index.html
#   make figure-12                                                  one of them
#
# Every rule writes a folder: pictures (.png, with the .exr they were made from), drawings (.svg, with their tables), and
# figure.json. Runs end after a number of passes, never after a time, so that a second run gives the same files.

QUALITY ?= full
FIGURES_OUT ?= out/figures
BIN := target/release
DRAW := $(BIN)/figures
# Each quality has its own references, because their sizes differ.
REFERENCES := $(FIGURES_OUT)/reference-$(QUALITY)
# With -e, a loop ends at the first run that fails. Otherwise it would continue, and use an older picture instead of the
# missing one.
.SHELLFLAGS := -ec

# $(call q,QUICK,FULL): a value that depends on the quality.
q = $(if $(filter quick,$(QUALITY)),$(1),$(2))
SIZE := $(call q,128x128,512x512)
WIDE := $(call q,160x90,640x360)
, := ,
# The folder of the current figure.
D = $(FIGURES_OUT)/$(@:figure-%=%)
RUN = --size $(SIZE) --quiet
# Drawings over pictures need a large picture, but few samples.
OVER = --size $(call q,384x384,512x512) --quiet
OVER_WIDE = $(call q,320x240,512x384)

BOX := scenes/cornell-box.xml
SPHERES := scenes/cornell-spheres.xml
GLOSSY := scenes/cornell-glossy.xml

SLIDES := 3 8 9 12 13 14 15 16 17 18 19 22 23 24 25 26 27 29 31 32 33 34 35 36 39 41 43 47 49 51 53 55 57 59 61 62
.PHONY: figures programs $(SLIDES:%=figure-%)

figures: $(SLIDES:%=figure-%)
	$(DRAW) index $(FIGURES_OUT)/index.html $(SLIDES:%=$(FIGURES_OUT)/%)
	@echo "$(FIGURES_OUT)/index.html"

programs:
	$(CARGO) build --release --workspace --quiet

$(SLIDES:%=figure-%): | programs
$(SLIDES:%=figure-%): export RUST_BACKTRACE = 0

# ------------------------------------------------------------------ references: long runs of the path tracer
# reference-QUALITY/SCENE.exr, or reference-QUALITY/SCENE.LAYER.exr for one component.
REFERENCE_SPP := $(call q,256,2048)
$(REFERENCES)/%.exr: | programs
	@mkdir -p $(REFERENCES)
	$(BIN)/pathtrace scenes/$(firstword $(subst ., ,$*)).xml $(RUN) --spp $(REFERENCE_SPP) $(patsubst %,--component %,$(word 2,$(subst ., ,$*))) -o $@ --seed 99

# ------------------------------------------------------------------ 3, 4: what global illumination is
figure-3:
	mkdir -p $D
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,1024) -o $D/all.exr
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,1024) --component direct -o $D/direct.exr
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,1024) --component indirect -o $D/indirect.exr
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,1024) --component caustic -o $D/caustic.exr
	$(DRAW) figure $D --slide 3-4 --columns 4 --title "Global illumination, and indirect light alone" \
	  --caption "All light is the sum of its components. Indirect light, scattered at least twice, changes slowly over diffuse surfaces; irradiance caching relies on this. Light focused by the glass sphere changes quickly." \
	  all.png="everything" direct.png="direct" indirect.png="indirect" caustic.png="caustic"

# ------------------------------------------------------------------ 8 to 14: irradiance caching
IRR = $(BIN)/irrcache $(BOX) $(RUN) --component indirect --spp $(call q,4,16)
IRR_OVER = $(BIN)/irrcache $(BOX) $(OVER) --component indirect --spp $(call q,1,4)
figure-8:
	mkdir -p $D
	$(IRR_OVER) --rays $(call q,100,1000) --error split-sphere --show octree,octree-slice -o $D/cache.exr
	$(DRAW) figure $D --slide 8 --columns 2 --title "The octree of records" \
	  --caption "A cell is divided until it contains fewer than 3 records. Records are dense where surfaces are close: in corners and around the blocks." \
	  cache.octree-slice.png="a slice through the octree, its records as dots" cache.octree.png="its cells over the picture"

figure-9:
	mkdir -p $D
	$(IRR_OVER) --rays $(call q,100,1000) --error split-sphere --weights lecture --show weights,validity -o $D/cache.exr
	$(DRAW) figure $D --slide 9-11 --columns 2 --title "Where a record is valid" \
	  --caption "The weight w of one record falls with distance, in units of its harmonic mean distance, and with the angle between normals. Where w exceeds 10 (an error of 0.1) the record is used." \
	  cache.weights.png="weight w of the record nearest to the middle; the line is w = 10" cache.validity.png="the discs in which records are used"

figure-12: $(REFERENCES)/cornell-box.indirect.exr
	mkdir -p $D
	$(IRR) --rays $(call q,200,1000) --error split-sphere --weights lecture --gradients off -o $D/without.exr
	$(IRR) --rays $(call q,200,1000) --error split-sphere --weights lecture --gradients both -o $D/with.exr
	$(DRAW) difference $D/without-error.svg $D/without.exr --reference $< --most 0.2
	$(DRAW) difference $D/with-error.svg $D/with.exr --reference $< --most 0.2
	$(DRAW) figure $D --slide 12 --columns 2 --exposure 1.5 --title "Irradiance gradients" --reference $< \
	  --caption "The same records, interpolated without and with gradients (1000 rays per record at full quality, w > 10). Without gradients, every record shows as a step." \
	  without.png="without gradients" with.png="with gradients" without-error.svg="relative error, without" with-error.svg="relative error, with"

figure-13:
	mkdir -p $D
	$(IRR_OVER) --rays $(call q,200,1000) --error split-sphere --show records -o $D/records.exr
	$(IRR_OVER) --rays $(call q,200,1000) --show records -o $D/hessian.exr
	$(DRAW) figure $D --slide 13 --columns 2 --title "Cache positions" \
	  --caption "Positions of the records, coloured by the radius within which they are valid (dark: small, bright: large)." \
	  records.records.png="the slides' split sphere, w > 10" hessian.records.png="error by Hessians with occlusion (the default)"

RAYS := $(call q,30 100 300,100 300 1000 3000 5000)
ACCURACIES := $(call q,0.1 0.3 0.5,0.05 0.1 0.2 0.35 0.5)
figure-14: $(REFERENCES)/cornell-box.indirect.exr
	mkdir -p $D
	for n in $(RAYS); do $(IRR) --rays $$n --error split-sphere -o $D/rays-$$n.exr; done
	for a in $(ACCURACIES); do $(IRR) --rays $(call q,100,1000) --error split-sphere --accuracy $$a -o $D/accuracy-$$a.exr; done
	$(DRAW) measure $D/rays.csv --reference $< $(foreach n,$(RAYS),$n=$D/rays-$n.exr)
	$(DRAW) measure $D/accuracy.csv --reference $< $(foreach a,$(ACCURACIES),$a=$D/accuracy-$a.exr)
	$(DRAW) plot $D/rays.svg --title "Error against rays per record" --x "rays" --y "relMSE" --log xy "split sphere, w > 10"=$D/rays.csv:x:relmse
	$(DRAW) plot $D/accuracy.svg --title "Error against accuracy" --x "accuracy a (w > 1/a)" --y "relMSE" --log xy "split sphere"=$D/accuracy.csv:x:relmse
	$(DRAW) figure $D --slide 14 --columns 3 --exposure 1.5 --title "More rays" --reference $< \
	  --caption "More rays make better records. The remaining error is that of interpolation, which the accuracy bounds." \
	  rays-$(lastword $(RAYS)).png="$(lastword $(RAYS)) rays" rays.svg="error against rays" accuracy.svg="error against accuracy"

# ------------------------------------------------------------------ 15 to 20: radiance caching
RAD = $(BIN)/radcache $(GLOSSY) $(RUN) --component indirect --rays $(call q,200,1000) --glossy-rays $(call q,500,2000)
figure-15: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(RAD) --mode rho-e --spp $(call q,8,64) -o $D/naive.exr
	$(RAD) --spp $(call q,8,64) -o $D/cached.exr
	cp $< $D/reference.exr && cp $(<:.exr=.png) $D/reference.png
	$(DRAW) figure $D --slide 15 --columns 3 --exposure 1.5 --title "Glossy surfaces are not a product" --reference $< \
	  --caption "Indirect light on a plastic floor and a copper block. The product of hemispherical reflectance and irradiance ignores the direction of the light: highlights are missing." \
	  naive.png="rho_hd(w) E, the naive product" cached.png="radiance caching" reference.png="path tracing, the reference"

figure-16: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(RAD) --spp $(call q,8,32) -o $D/cached.exr
	$(BIN)/pathtrace $(GLOSSY) $(RUN) --component indirect --spp $(call q,64,128) -o $D/paths.exr
	$(DRAW) difference $D/cached-error.svg $D/cached.exr --reference $< --most 0.5
	$(DRAW) difference $D/paths-error.svg $D/paths.exr --reference $< --most 0.5
	$(DRAW) figure $D --slide 16,20 --columns 2 --exposure 1.5 --title "Radiance caching against path tracing" --reference $< \
	  --caption "Indirect light in about the same time (below each picture). The reflection of the silver ball is too sharp for the cache, so the ball is path-traced in both." \
	  cached.png="radiance caching" paths.png="path tracing" cached-error.svg="relative error, cached" paths-error.svg="relative error, paths"

figure-17:
	mkdir -p $D
	$(RAD) --spp $(call q,8,32) --cache-out $D/box.cache -o $D/first.exr
	$(RAD) --spp $(call q,8,32) --cache-in $D/box.cache --origin=120,380,-680 --target=310,190,280 -o $D/second.exr
	$(DRAW) figure $D --slide 17 --columns 2 --exposure 1.5 --title "View dependence" \
	  --caption "One cache, two views: records store incoming light by direction, and each view evaluates the BRDF for its own direction. The second view adds records only where the first had none." \
	  first.png="the view that filled the cache" second.png="another view from the same cache"

ORDERS := $(call q,1 2 4 8,1 2 3 4 6 8 10 12)
figure-18: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(BIN)/radcache $(GLOSSY) $(OVER) --rays 100 --glossy-rays 200 --spp 1 --show basis,brdf -o $D/sh.exr
	for n in $(ORDERS); do $(RAD) --order $$n --spp $(call q,8,32) -o $D/order-$$n.exr; done
	$(DRAW) measure $D/order.csv --reference $< $(foreach n,$(ORDERS),$n=$D/order-$n.exr)
	$(DRAW) plot $D/order.svg --title "Error against order" --x "order n (n^2 functions)" --y "relMSE" --log y "spherical harmonics"=$D/order.csv:x:relmse
	$(DRAW) figure $D --slide 18 --columns 3 --title "Incoming radiance in spherical harmonics" \
	  --caption "The basis to l = 4; a rough BRDF times cosine and its expansions of orders 1 to 10; the error of the picture against the order. At high orders, the noise of the records remains." \
	  sh.basis.png="the basis functions" sh.brdf.png="a BRDF and its expansions" order.svg="error against order"

figure-19: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(BIN)/radcache $(GLOSSY) $(OVER) --rays 100 --glossy-rays 200 --spp 1 --show samples -o $D/lobe.exr
	for n in 4 64; do $(BIN)/pathtrace $(GLOSSY) $(RUN) --component indirect --spp $$n -o $D/paths-$$n.exr; done
	$(DRAW) figure $D --slide 19 --columns 3 --title "Monte Carlo with importance sampling" --exposure 1.5 --reference $< \
	  --caption "Directions sampled by the BRDF times the cosine are dense where it is large (blue); those sampled by the cosine alone are not (orange). Each path still samples one direction per bounce: noise falls as one over the square root of the number of samples." \
	  lobe.samples.png="300 directions by cosine, and 300 by BRDF" paths-4.png="4 paths per pixel" paths-64.png="64"

# ------------------------------------------------------------------ 22 to 32: photon mapping
PHOTONS := $(call q,20000,100000)
# Pixels of the floor in the glass sphere's caustic, and in the ring's crescent.
RING_OVER := $(if $(filter quick,$(QUALITY)),115$(,)174,154$(,)232)
FLOOR_OVER := $(if $(filter quick,$(QUALITY)),150$(,)352,200$(,)470)
SPOT := $(if $(filter quick,$(QUALITY)),88$(,)114,352$(,)456)
CRESCENT := $(if $(filter quick,$(QUALITY)),38$(,)58,154$(,)232)
PM = $(BIN)/photonmap $(SPHERES) $(RUN) --photons $(PHOTONS) --caustic-photons $(PHOTONS)
PM_OVER = $(BIN)/photonmap $(SPHERES) $(OVER) --photons $(PHOTONS) --caustic-photons $(PHOTONS) --spp $(call q,1,16)
figure-22:
	mkdir -p $D
	$(PM_OVER) --gather direct --show paths -o $D/photons.exr
	$(DRAW) figure $D --slide 22 --columns 1 --title "Photon tracing" \
	  --caption "The first photon paths from the lamp, over the picture: reflected by walls and mirror, refracted by glass, absorbed." photons.paths.png="photon paths"

figure-23:
	mkdir -p $D
	$(PM_OVER) --gather direct --show photons -o $D/photons.exr
	$(DRAW) figure $D --slide 23 --columns 1 --title "Photon density" \
	  --caption "Every photon of the global map as a dot: their density gives the irradiance." photons.photons.png="$(PHOTONS) photons"

figure-24: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	for s in 1 2 3 4; do $(PM) --spp 1 --seed $$s --probe $(SPOT) --probe-out $D/probe-$$s.csv -o $D/probe-$$s.exr; done
	$(DRAW) plot $D/estimate.svg --title "The estimate at a point against k" --x "photons of the estimate, k" --y "irradiance, green" --log x \
	  $(foreach s,1 2 3 4,"map $s"=$D/probe-$s.csv:k:green)
	$(DRAW) figure $D --slide 24 --columns 1 --title "Radiance estimate" \
	  --caption "Estimates from few photons are noisy: maps with different seeds disagree. Estimates from many photons average over a large area and over edges: all maps agree on a wrong value." estimate.svg="four photon maps, one point of the floor"

figure-25:
	mkdir -p $D
	$(PM_OVER) --gather direct --show cells -o $D/tree.exr
	$(DRAW) figure $D --slide 25 --columns 1 --title "The balanced kd-tree" \
	  --caption "Cells of the tree over real photons. A photon takes 20 bytes: float position, power as RGBE, direction as two bytes, the split plane." tree.cells.png="cells of the tree"

figure-26:
	mkdir -p $D
	$(PM_OVER) --show photons -o $D/photons.exr
	$(DRAW) figure $D --slide 26 --columns 2 --title "Two photon maps" \
	  --caption "The global map contains the light that any surface received. The caustic map contains only light that came through mirrors and glass: many more photons in few places." \
	  photons.photons.png="global map" photons.caustic-photons.png="caustic map"

figure-27:
	mkdir -p $D
	$(BIN)/photonmap scenes/ring.xml $(OVER) --photons $(PHOTONS) --caustic-photons $(PHOTONS) --spp $(call q,1,16) --show gathering --probe $(RING_OVER) -o $D/ring.exr
	$(PM_OVER) --gather-rays 48 --show gathering --probe $(FLOOR_OVER) -o $D/box.exr
	$(DRAW) figure $D --slide 27-28 --columns 2 --title "Caustics at the first bounce, indirect light at the second" \
	  --caption "At the first diffuse surface of an eye path, the caustic map is read (left: the last segments of its photons, which come from the ring to the white dot). For the other light, gather rays start there, and the global map is read where they end (right)." \
	  ring.caustic-gather.png="photons of a caustic estimate" box.final-gather.png="gather rays to the second bounce"

figure-29: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	$(PM) --gather none --lookup 50 --kernel lecture --spp $(call q,4,16) -o $D/density.exr
	$(PM) --gather direct --lookup 50 --kernel lecture --spp $(call q,16,64) -o $D/direct.exr
	$(DRAW) figure $D --slide 29-30 --columns 2 --title "Photon maps seen directly" --reference $< \
	  --caption "$(PHOTONS) photons, 50 per estimate, evaluated at the first diffuse surface of an eye path: blotches, and dark rims where the disc of the estimate extends beyond the surface." \
	  density.png="all light from the map" direct.png="direct light by shadow rays, the rest from the map"

figure-31: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	$(PM) --spp $(call q,16,64) -o $D/gather.exr
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,512) -o $D/paths.exr
	$(DRAW) difference $D/gather-error.svg $D/gather.exr --reference $< --most 0.2
	$(DRAW) figure $D --slide 31 --columns 3 --title "Final gather" --reference $< \
	  --caption "The density is estimated one bounce later: rays from the first diffuse surface average many estimates, so the blotches disappear." \
	  gather.png="photon mapping with final gather" gather-error.svg="relative error" paths.png="path tracing"

figure-32:
	mkdir -p $D
	$(BIN)/photonmap scenes/cognac.xml -D tint=1,1,1 -D absorption=0.36,2.08,6.37 $(RUN) --photons $(PHOTONS) --caustic-photons $(call q,100000,1000000) --spp $(call q,16,128) -o $D/cognac.exr
	$(DRAW) figure $D --slide 32 --columns 1 --title "A glass of cognac" \
	  --caption "Light through glass and an amber liquid that absorbs: the liquid colours the caustic on the table, and is darker where it is deep." cognac.png="photon mapping, caustic map"

figure-33:
	mkdir -p $D
	$(BIN)/photonmap scenes/pavilion.xml --size $(WIDE) --quiet --photons $(call q,50000,1000000) --caustic-photons $(PHOTONS) --spp $(call q,16,256) -o $D/pavilion.exr
	$(DRAW) figure $D --slide 33 --columns 1 --title "A house under the sky" \
	  --caption "Slabs, glass walls, a pool, and a wall of onyx, under sun and sky. The light under the roof was reflected by the pavement and the ceiling." pavilion.png="photon mapping with final gather"

# Light inside media: most of the light from the stone was scattered many times inside it.
SOLID = $(BIN)/photonmap --volume-photons $(call q,100000,1000000) --volume-lookup 60 --photons $(PHOTONS) --spp $(call q,16,128)
figure-34:
	mkdir -p $D
	$(SOLID) scenes/marble.xml $(RUN) -o $D/marble.exr
	$(SOLID) scenes/marble.xml $(RUN) --subsurface dipole -o $D/marble-dipole.exr
	$(BIN)/pathtrace scenes/marble.xml $(RUN) --mode volpath --spp $(call q,64,1024) -o $D/volpath.exr
	$(SOLID) scenes/milk.xml $(RUN) -o $D/milk.exr
	$(SOLID) scenes/milk.xml $(RUN) --subsurface dipole -o $D/milk-dipole.exr
	$(BIN)/photonmap scenes/fog.xml $(RUN) --volume-photons $(call q,100000,500000) --photons $(PHOTONS) --spp $(call q,4,32) -o $D/fog.exr
	$(DRAW) figure $D --slide 34 --columns 3 --title "Subsurface scattering" \
	  --caption "Marble lit from behind, milk, and a caustic in mist, from photons stored where the medium scatters them. The dipole treats every point as if it were on a flat half-space: its picture is smooth, but too dark where the stone is thin and lit from behind. The path tracer's rays leave the polished stone toward the lamp only by luck: its picture is right on average, but noisy." \
	  marble.png="photons in the medium" marble-dipole.png="dipole" volpath.png="volumetric path tracing" \
	  milk.png="milk, photons" milk-dipole.png="milk, dipole" fog.png="mist around a glass ball"

# ------------------------------------------------------------------ 35 to 46: progressive photon mapping
figure-35:
	mkdir -p $D
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --spp $(call q,128,1024) -o $D/paths.exr
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --mode bdpt --spp $(call q,32,256) -o $D/bdpt.exr
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --mode vcm --spp $(call q,32,256) -o $D/vcm.exr
	$(BIN)/photonmap scenes/bulb.xml $(RUN) --photons $(PHOTONS) --caustic-photons $(call q,100000,1000000) --spp $(call q,16,64) -o $D/photonmap.exr
	$(BIN)/ppm scenes/bulb.xml $(RUN) --passes $(call q,64,512) -o $D/ppm.exr
	$(BIN)/pathtrace $(SPHERES) $(OVER) --mode bdpt --show strategies --spp $(call q,16,128) -o $D/ways.exr
	$(DRAW) figure $D --slide 35,38 --columns 3 --title "All light is caustic" \
	  --caption "A lamp inside a glass shell: paths from the eye find it only by chance. Through the shell, bidirectional path tracing sees the walls only by chance too; merging finds that light. Times are shown below the pictures. Last: what each way to connect a path finds in a Cornell box. A row per number of segments, 1 to 5; from left to right, 0, 1, 2, ... vertices on the light's side." \
	  paths.png="path tracing" bdpt.png="bidirectional path tracing" vcm.png="vertex connection and merging" photonmap.png="photon mapping" ppm.png="progressive photon mapping" \
	  ways.pyramid-unweighted.png="all ways of bidirectional path tracing, not weighted" ways.pyramid.png="weighted: they sum to the picture"

# N^beta of N photons: with ppa, the radius shrinks so that a fraction alpha of each pass's photons stays; beta = alpha.
BETAS := 0.5 0.67 0.8 1
LADDER := $(call q,1 4 16 64,1 4 16 64 256)
RING = $(BIN)/ppm scenes/ring.xml $(RUN) --method ppa --component caustic --initial-radius 0.006 --photons $(call q,20000,50000)
figure-39:
	mkdir -p $D
	$(RING) --alpha 0.67 --seed 7 --passes $(call q,512,4096) -o $D/reference.exr
	for b in $(BETAS); do for n in $(LADDER); do $(RING) --alpha $$b --passes $$n -o $D/beta-$$b-$$n.exr; done; done
	$(foreach b,$(BETAS),$(DRAW) measure $D/beta-$b.csv --layer Caustic --reference $D/reference.exr $(foreach n,$(LADDER),$n=$D/beta-$b-$n.exr) &&) true
	$(DRAW) plot $D/error.svg --title "Error against passes" --x "passes (N grows with them)" --y "relMSE of the caustic" --log xy --slopes $(foreach b,$(BETAS),"beta $b"=$D/beta-$b.csv:x:relmse)
	$(DRAW) figure $D --slide 39-40 --columns 3 --title "Noise and bias must shrink together" --reference $D/reference.exr --layer Caustic \
	  --caption "Of N photons, N^beta are used. With beta = 1 the radius stays constant, and the bias remains in the error; smaller values give less bias but more noise. The reference is a long run with beta 2/3." \
	  error.svg="error against passes" $(foreach b,0.5 1,beta-$b-$(lastword $(LADDER)).png="beta $b$(,) $(lastword $(LADDER)) passes")

figure-36:
	mkdir -p $D
	$(PM) --spp $(call q,4,16) --stats $D/photonmap.json -o $D/photonmap.exr
	$(BIN)/ppm $(SPHERES) $(RUN) --method ppm --passes $(call q,16,64) --stats $D/ppm.json -o $D/ppm.exr
	$(DRAW) flow $D/photonmap.svg --title "Photon mapping" --stats $D/photonmap.json \
	  "{technique.global_paths} photon paths,|{technique.caustic_paths} more aimed|at glass and mirror" \
	  "{technique.global_photons} photons stored|and {technique.caustic_photons} for caustics" "kd-trees|{technique.global_bytes} and|{technique.caustic_bytes} bytes" \
	  "{passes} paths per pixel|from the eye|read both maps"
	$(DRAW) flow $D/ppm.svg --title "Progressive photon mapping" --stats $D/ppm.json --again 2,3 \
	  "{size.0} x {size.1} hit points|of paths from the eye|first R {technique.initial_radius_mean} (mean)" "{technique.photon_paths} photon paths|in {passes} passes|none is kept" \
	  "{technique.photons_contributed} contributions|R and tau of every|hit point anew" "L = tau / (pi R^2 n)"
	$(DRAW) figure $D --slide 36-37 --columns 1 --title "Two passes, or many" \
	  --caption "Photon mapping stores all photons, then traces eye paths. Progressive photon mapping traces eye paths once, keeps their hit points, and does not store photons, so there is no limit to their number. The numbers are from real runs." \
	  photonmap.svg="photon mapping" ppm.svg="progressive photon mapping"

PASSES := $(call q,64,512)
ALPHAS := 0.5 0.7 0.9
figure-41:
	mkdir -p $D
	for a in $(ALPHAS); do $(BIN)/ppm scenes/ring.xml $(RUN) --photons $(call q,60000,100000) --passes $(PASSES) --alpha $$a --trace-pixel $(CRESCENT) --trace-out $D/alpha-$$a.csv --show radius -o $D/alpha-$$a.exr; done
	$(DRAW) plot $D/radius.svg --title "Radius of a hit point" --x "passes" --y "R (world units)" --log xy --slopes $(foreach a,$(ALPHAS),"alpha $a"=$D/alpha-$a.csv:pass:radius)
	$(DRAW) plot $D/photons.svg --title "Number of photons N" --x "passes" --y "N" --log xy --slopes $(foreach a,$(ALPHAS),"alpha $a"=$D/alpha-$a.csv:pass:N)
	$(DRAW) figure $D --slide 41-42 --columns 3 --title "Radius reduction" \
	  --caption "R' = R sqrt((N + alpha M) / (N + M)) after every pass: the radius shrinks as a power of the number of passes, and N still grows." \
	  radius.svg="R" photons.svg="N" alpha-0.7.radius.png="the map of R for alpha 0.7"

figure-43:
	mkdir -p $D
	for n in 1 10 $(call q,50,100 1000); do $(BIN)/ppm scenes/torus-in-glass.xml $(RUN) --passes $$n -o $D/torus-$$n.exr; $(BIN)/ppm scenes/pool.xml $(RUN) --passes $$n -o $D/pool-$$n.exr; done
	$(DRAW) figure $D --slide 43-46 --columns $(call q,3,4) --title "The picture over the passes" \
	  --caption "A torus inside glass, and the floor of a pool: all light goes through glass or water on its way there and on its way to the eye. Noise and blur shrink together." \
	  $(foreach n,1 10 $(call q,50,100 1000),torus-$n.png="$n passes") $(foreach n,1 10 $(call q,50,100 1000),pool-$n.png="$n passes")

# ------------------------------------------------------------------ 47 to 52: instant radiosity
VPL = $(BIN)/instant-radiosity $(BOX) $(RUN)
figure-47:
	mkdir -p $D
	for s in 0 1 2 3; do $(VPL) --direct vpl --component direct --vpls 1 --spp 1 --first-pass $$s -o $D/light-$$s.exr; done
	for n in 4 16 64; do $(VPL) --direct vpl --component direct --vpls 1 --spp $$n -o $D/mean-$$n.exr; done
	$(VPL) --component direct --spp 256 -o $D/sampled.exr
	$(DRAW) figure $D --slide 47-48 --columns 4 --title "Soft shadows as the mean of hard shadows" --reference $D/sampled.exr \
	  --caption "Each picture uses one point on the area light. Averaging many pictures gives soft shadows, as in the accumulation buffer." \
	  $(foreach s,0 1 2 3,light-$s.png="one light") $(foreach n,4 16 64,mean-$n.png="mean of $n") sampled.png="the light sampled"

figure-49:
	mkdir -p $D
	$(BIN)/instant-radiosity $(BOX) $(OVER) --vpls 64 --spp $(call q,2,16) --show vpls,connections -o $D/vpls.exr
	$(DRAW) figure $D --slide 49-50 --columns 2 --title "Virtual point lights" \
	  --caption "Every vertex of a light path becomes a point light; shadow rays connect each visible point with all of them." \
	  vpls.vpls.png="where the lights are" vpls.connections.png="shadow rays of one point: red ones are occluded"

# 16 passes with N/16 lights each give N lights.
COUNTS := $(call q,64 1024,64 1024 16384)
CLAMPS := 0.1 0.3 1 3 10 30 100 1000
ONE_SET = $(VPL) --component indirect --spp $(call q,4,16)
figure-51: $(REFERENCES)/cornell-box.indirect.exr
	mkdir -p $D
	for n in $(COUNTS); do \
	  $(ONE_SET) --vpls $$((n / $(call q,4,16))) --clamp inf -o $D/unclamped-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(call q,4,16))) --compensation none -o $D/clamped-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(call q,4,16))) -o $D/compensated-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(call q,4,16))) --vsl -o $D/spheres-$$n.exr; \
	  for k in unclamped clamped compensated spheres; do $(DRAW) difference $D/$$k-$$n.svg $D/$$k-$$n.exr --reference $< --most 0.5; done; \
	done
	for c in $(CLAMPS); do $(VPL) --component indirect --vpls 1024 --spp 1 --clamp $$c --compensation none -o $D/clamp-$$c.exr; done
	$(VPL) --component indirect --vpls 1024 --spp 1 --clamp inf -o $D/whole.exr
	$(DRAW) measure $D/clamp.csv --reference $D/whole.exr $(foreach c,$(CLAMPS),$c=$D/clamp-$c.exr)
	$(DRAW) plot $D/clamp.svg --title "Remaining light" --x "bound of the geometry term (1 / squared scene radius)" --y "mean of the clamped picture / unclamped" --log x "red"=$D/clamp.csv:x:ratio_r "green"=$D/clamp.csv:x:ratio_g "blue"=$D/clamp.csv:x:ratio_b
	$(DRAW) figure $D --slide 51-52 --columns 4 --exposure 1.5 --title "Instant radiosity: bright spots, dark corners, and remedies" --reference $< \
	  --caption "Indirect light from more and more lights. Without a bound, every light causes a bright spot near itself. With a bound, corners are too dark. Paths restore the light that was cut off; lights as spheres blur instead." \
	  $(foreach n,$(COUNTS),$(foreach k,unclamped clamped compensated spheres,$k-$n.png="$n lights: $k" )) \
	  $(foreach n,$(lastword $(COUNTS)),$(foreach k,unclamped clamped compensated spheres,$k-$n.svg="$n lights: error, $k" )) \
	  clamp.svg="energy lost against the bound"

# ------------------------------------------------------------------ 53 to 62: lightcuts
CUTS = $(BIN)/lightcuts
# Numbers of points on light sources; as many again are on surfaces.
MANY := $(call q,16 128 1024,16 64 256 1024 4096 16384 65536)
figure-53:
	mkdir -p $D
	$(CUTS) scenes/patio.xml --size $(call q,128x96,512x384) --quiet --rule cluster --lights $(call q,1000,50000) --vpls $(call q,1000,50000) --spp $(call q,2,16) -o $D/patio.exr
	$(CUTS) scenes/patio.xml -D sun=0 --size $(call q,128x96,512x384) --quiet --rule cluster --lights $(call q,1000,50000) --vpls $(call q,1000,50000) --spp $(call q,2,16) -o $D/sky.exr
	for n in $(MANY); do for m in cuts all; do \
	  $(CUTS) scenes/gallery.xml --size 64x48 --quiet --rule cluster --max-cut 100000 --method $$m --lights $$n --vpls $$n --compensation none --spp 1 -o $D/$$m-$$n.exr; \
	done; done
	for m in cuts all; do $(DRAW) measure $D/$$m.csv --reference $D/all-$(lastword $(MANY)).exr $(foreach n,$(MANY),$n=$D/$$m-$n.exr); done
	$(DRAW) plot $D/cost.svg --title "Cost against the number of lights" --x "points on light sources, and as many on surfaces" --y "seconds for a picture of 64 x 48" --log xy --slopes "lightcuts"=$D/cuts.csv:x:seconds "all lights"=$D/all.csv:x:seconds
	$(DRAW) figure $D --slide 53-54 --columns 3 --title "Many lights of all kinds" --exposure 1 \
	  --caption "Sun, sky and indirect light as one set of point lights. The cost of using all of them is linear in their number; the cost of cuts grows more slowly." \
	  patio.png="sun, sky and indirect light" sky.png="sky and indirect light" cost.svg="seconds against lights"

GALLERY = $(CUTS) scenes/gallery.xml --size $(call q,320x240,512x384) --quiet --rule cluster --lights $(call q,256,1024) --vpls $(call q,1000,16384) --spp 1
figure-55:
	mkdir -p $D
	$(GALLERY) --show clusters -o $D/gallery.exr
	$(DRAW) figure $D --slide 55-56 --columns 2 --title "Clusters of lights" \
	  --caption "Lights that are near each other and emit in similar directions are joined to clusters. The lights are drawn over the picture, coloured by cluster, at four levels of the light tree." \
	  $(foreach n,2 8 32 128,gallery.clusters-$n.png="$n clusters per tree")

figure-57:
	mkdir -p $D
	$(CUTS) scenes/gallery.xml -D lights=4 --size $(OVER_WIDE) --quiet --rule cluster --error 0.1 --lights 16 --component direct --spp 4 --show tree -o $D/tree.exr
	$(DRAW) figure $D --slide 57-58 --columns 2 --title "A light tree, and a cut" \
	  --caption "A tree of 16 lights, and the cut that was chosen for the pixel in the middle: every light is in exactly one of its clusters." \
	  tree.tree.png="the tree with its cut" tree.png="the scene"

figure-59:
	mkdir -p $D
	$(CUTS) scenes/gallery.xml -D lights=4 --size $(OVER_WIDE) --quiet --lights 4 --fixed-lights --component direct --spp $(call q,4,16) --show cuts --cuts-out $D/cuts.csv -o $D/four.exr
	$(DRAW) figure $D --slide 59-60 --columns 4 --title "Four lights, and their cuts" \
	  --caption "The exact picture, and pictures in which some lights represent others. Each cut is accurate at some points and inaccurate at others, so each point gets its own cut." \
	  four.cut-0.png="all four lights" $(foreach k,1 2 3,four.cut-$k.png="cut $k")

figure-61:
	mkdir -p $D
	$(GALLERY) --show cut-size,bounds --bounds-out $D/bounds.csv -o $D/gallery.exr
	$(DRAW) figure $D --slide 61 --columns 3 --title "Bound the error, refine to 2 %" \
	  --caption "Clusters are refined until the error bound of each one is below 2 % of the total light. The bounds (vertical) are above the true errors (horizontal); where the bounds are loose, cuts are larger than necessary." \
	  gallery.png="the picture" gallery.cut-size.png="clusters per cut, dark: few, bright: many" gallery.bounds.png="bound against error, both logarithmic"

figure-62:
	mkdir -p $D
	$(CUTS) scenes/colonnade.xml --size $(WIDE) --quiet --rule cluster --lights $(call q,1000,20000) --vpls $(call q,1000,20000) --spp $(call q,2,32) -o $D/colonnade.exr
	$(DRAW) figure $D --slide 62 --columns 1 --title "An atrium by lightcuts" \
	  --caption "Sun and sky fall into an atrium; nearly all light under the galleries was reflected by walls, floor and drapes." colonnade.png="lightcuts"
