# The lecture's figures, one rule per slide. Each recipe documents its figure: what is run, on which scene, what to look for, and
# which claims of its caption are checked.
#
#   make figures [QUALITY=quick|default|full] [FIGURES_OUT=out/figures]     all of them, with index.html and deck.html
#   make figure-12                                                          the figure of a slide
#   make mistakes                                                           classic mistakes, beside the right way
#
# Every rule writes a folder: pictures (.png, with the .exr they were made from), drawings (.svg, with their tables), and
# figure.json. A figure fails if a claim of its caption is false in its data. Runs end after a number of passes, never after a
# time, so that a second run gives the same pictures.

# quick: two minutes, noisy, for a look and for tests. default: 15 minutes, for reading. full: for a projector.
QUALITY ?= default
FIGURES_OUT ?= out/figures
BIN := target/release
DRAW := $(BIN)/figures
ifneq ($(words $(QUALITY)) $(filter quick default full,$(QUALITY)),1 $(QUALITY))
$(error QUALITY=$(QUALITY) is unknown: use quick, default or full)
endif
# Each quality has its own references, because their sizes differ.
REFERENCES := $(FIGURES_OUT)/reference-$(QUALITY)
# With -e, a loop ends at the first run that fails. Otherwise it would continue, and use an older picture instead of the
# missing one.
.SHELLFLAGS := -ec

# $(call q,QUICK,DEFAULT,FULL): a value that depends on the quality.
q = $(if $(filter quick,$(QUALITY)),$(1),$(if $(filter full,$(QUALITY)),$(3),$(2)))
SIZE := $(call q,128x128,288x288,1024x1024)
WIDE := $(call q,160x90,480x270,1280x720)
, := ,
# The folder of the current figure.
D = $(FIGURES_OUT)/$(@:figure-%=%)
RUN = --size $(SIZE) --quiet
# Drawings over pictures need a large picture, but few samples.
OVER_SIZE := $(call q,320,640,1024)
OVER = --size $(OVER_SIZE)x$(OVER_SIZE) --quiet
OVER_WIDE := $(call q,320x240,640x480,1024x768)
# Curves over many runs need small pictures.
SMALL = --size $(call q,96x96,160x160,256x256) --quiet

BOX := scenes/cornell-box.xml
SPHERES := scenes/cornell-spheres.xml
GLOSSY := scenes/cornell-glossy.xml

SLIDES := 3 8 9 12 13 14 15 16 17 18 19 22 23 24 25 26 27 29 31 32 33 34 35 36 39 41 43 47 49 51 53 55 57 59 61 62
# Further slides of figures: SLIDE:FIGURE.
ALSO := 4:3 10:9 11:9 20:16 28:27 30:29 37:36 38:35 40:39 42:41 44:43 45:43 46:43 48:47 50:49 52:51 54:53 56:55 58:57 60:59
.PHONY: figures programs techniques mistakes $(SLIDES:%=figure-%) $(foreach a,$(ALSO),figure-$(firstword $(subst :, ,$(a))))

# Draw all figures of the lecture, with QUALITY=quick|default|full: out/figures/index.html, and deck.html for the projector.
figures: $(SLIDES:%=figure-%)
	$(DRAW) index $(FIGURES_OUT)/index.html $(SLIDES:%=$(FIGURES_OUT)/%)
	$(DRAW) deck $(FIGURES_OUT)/deck.html $(SLIDES:%=$(FIGURES_OUT)/%)
	@echo "$(FIGURES_OUT)/index.html $(FIGURES_OUT)/deck.html"

programs:
	$(CARGO) build --release --workspace --quiet

$(SLIDES:%=figure-%): | programs
$(SLIDES:%=figure-%): export RUST_BACKTRACE = 0

# The figure of a slide that shares it with another slide.
define also
figure-$(firstword $(subst :, ,$(1))): figure-$(lastword $(subst :, ,$(1)))
endef
$(foreach a,$(ALSO),$(eval $(call also,$(a))))

# A slide without a figure is refused by its number.
figure-%:
	@echo "make: slide $* has no figure; slides with figures: $(shell echo $(SLIDES) $(foreach a,$(ALSO),$(firstword $(subst :, ,$(a)))) | tr ' ' '\n' | sort -n | tr '\n' ' ')" >&2
	@exit 2

# ------------------------------------------------------------------ references: long runs of the path tracer, shared by figures
# reference-QUALITY/SCENE.exr, or reference-QUALITY/SCENE.LAYER.exr for one component; in reference-QUALITY-small, pictures of the
# size SMALL. Each has a twin with another seed, so that relMSE and RMSE do not contain the reference's noise: the mean of
# (x - a) (x - b) is the squared error against the truth, if the noise of a and b is independent.
REFERENCE_SPP := $(call q,128,512,384)
REFER = $(BIN)/pathtrace scenes/$(firstword $(subst ., ,$*)).xml --spp $(REFERENCE_SPP) $(patsubst %,--component %,$(word 2,$(subst ., ,$*)))
# The twins are targets of their own, so that one that is missing is made.
REFERENCE_NAMES := cornell-box.indirect cornell-glossy.indirect cornell-spheres
$(REFERENCE_NAMES:%=$(REFERENCES)/%.exr): $(REFERENCES)/%.exr: $(REFERENCES)/%.twin.exr | programs
	$(REFER) $(RUN) --seed 99 -o $@
$(REFERENCE_NAMES:%=$(REFERENCES)/%.twin.exr): $(REFERENCES)/%.twin.exr: | programs
	@mkdir -p $(@D)
	$(REFER) $(RUN) --seed 98 -o $@
$(REFERENCE_NAMES:%=$(REFERENCES)-small/%.exr): $(REFERENCES)-small/%.exr: $(REFERENCES)-small/%.twin.exr | programs
	$(REFER) $(SMALL) --seed 99 -o $@
$(REFERENCE_NAMES:%=$(REFERENCES)-small/%.twin.exr): $(REFERENCES)-small/%.twin.exr: | programs
	@mkdir -p $(@D)
	$(REFER) $(SMALL) --seed 98 -o $@
# Copy the figure's reference into its folder: reference.exr, its twin and its display image.
COPY_REFERENCE = for e in exr twin.exr png; do cp $(<:.exr=).$$e $D/reference.$$e; done

# ------------------------------------------------------------------ 3, 4: what global illumination is
figure-3: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	cp $< $D/all.exr && cp $(<:.exr=.twin.exr) $D/all.twin.exr
	$(DRAW) view $D/all.png $D/all.exr
	for layer in Direct Indirect Caustic; do $(DRAW) view $D/all.$$layer.png $D/all.exr --layer $$layer; done
	$(DRAW) figure $D --slide 3-4 --columns 4 --title "Global illumination, and indirect light alone" \
	  --caption "All light is the sum of its components. Indirect light, scattered at least twice, changes slowly over diffuse surfaces, compared to direct light with its shadows; irradiance caching relies on this. Light focused by the glass sphere changes quickly. All four pictures have the same exposure." \
	  --claim "(mean(all:Direct) + mean(all:Indirect) + mean(all:Caustic)) / mean(all) in 0.98..1.02" \
	  --claim "spread(all:Indirect[0.3 0.35 0.4 0.25]) < 0.3" --claim "spread(all:Indirect[0.15 0.82 0.7 0.12]) < 0.7 * spread(all:Direct[0.15 0.82 0.7 0.12])" \
	  --claim "spread(all:Caustic[0.6 0.86 0.18 0.08]) > 1" \
	  all.png="everything" all.Direct.png="direct: {mean(all:Direct) / mean(all) %} of the light" all.Indirect.png="indirect: {mean(all:Indirect) / mean(all) %}" all.Caustic.png="caustic: {mean(all:Caustic) / mean(all) %}"

# ------------------------------------------------------------------ 8 to 14: irradiance caching
IRR = $(BIN)/irrcache $(BOX) $(RUN) --component indirect --spp $(call q,4,16,16)
IRR_OVER = $(BIN)/irrcache $(BOX) $(OVER) --component indirect --spp $(call q,1,4,4)
# The lecture's weights and split sphere.
LECTURE := --error split-sphere --weights lecture
figure-8:
	mkdir -p $D
	$(IRR_OVER) --rays $(call q,100,400,1000) $(LECTURE) --accuracy 0.3 --show octree-slice,records --records-out $D/records.csv --stats $D/cache.json -o $D/cache.exr
	$(DRAW) figure $D --slide 8 --columns 2 --title "The octree of records" \
	  --caption "A cell is divided into eight until it contains fewer than 3 records, so one can count: no cell has more than two. Records are dense where surfaces are close, in corners and around the blocks. {stat(cache.json:technique.records)} records in all." \
	  --claim "max(cache:Octree-slice.records) < 2.5" --claim "within(records.csv:x:y, 0 50 0 1) > 2 * within(records.csv:x:y, 100 150 0 1)" \
	  cache.octree-slice.png="the cells at the floor with their records, seen from above" cache.records.png="all records over the picture"

figure-9:
	mkdir -p $D
	$(IRR_OVER) --rays $(call q,100,400,1000) $(LECTURE) --accuracy 0.3 --show validity --stats $D/cache.json -o $D/cache.exr
	$(IRR_OVER) --rays $(call q,100,400,1000) $(LECTURE) --show weights -o $D/one.exr
	$(DRAW) figure $D --slide 9-11 --columns 2 --title "Where a record is valid" \
	  --caption "The weight w of a record falls with the distance from it, in units of its harmonic mean distance, and with the angle between normals. Where w exceeds 1/a (10 for an allowed error a of 0.1), the record is used." \
	  --claim "mean(one:Weights.w[0.285 0.44 0.01 0.02]) < 0.5 * mean(one:Weights.w[0.31 0.44 0.01 0.02])" \
	  --claim "mean(one:Weights.w[0.49 0.52 0.02 0.02]) > 10" --claim "mean(one:Weights.w[0.34 0.52 0.02 0.02]) < 10" --claim "mean(one:Weights.w[0.34 0.72 0.02 0.02]) < mean(one:Weights.w[0.34 0.52 0.02 0.02])" \
	  one.weights.png="weight w of the record nearest to the middle; inside the white line w > 10" cache.validity.png="discs in which records are used, for w > 3.3 ({stat(cache.json:technique.records)} records)"

figure-12: $(REFERENCES)/cornell-box.indirect.exr
	mkdir -p $D
	$(IRR) --rays 1000 $(LECTURE) --accuracy 0.5 --gradients off --stats $D/without.json -o $D/without.exr
	$(IRR) --rays 1000 $(LECTURE) --accuracy 0.5 --gradients both --stats $D/with.json -o $D/with.exr
	for g in off both; do $(IRR) --rays 1000 $(LECTURE) --gradients $$g --stats $D/$$g.json -o $D/fine-$$g.exr; done
	for p in without with; do $(DRAW) difference $D/$$p-error.svg $D/$$p.exr --reference $< --most 0.5; done
	$(DRAW) figure $D --slide 12 --columns 2 --exposure 2 --inset 0.16,0.2,0.26,0.26,2 --title "Irradiance gradients" --reference $< \
	  --caption "The same {stat(with.json:technique.records)} records (1000 rays each, w > 2), interpolated without and with gradients. Without them, every record shows as a disc with a step at its rim; with them the error is {relmse(without) / relmse(with)} times smaller. With w > 10 as on the slide, {stat(both.json:technique.records)} records are so dense that gradients matter less: relMSE {relmse(fine-off)} without, {relmse(fine-both)} with." \
	  --claim "relmse(with) < 0.6 * relmse(without)" --claim "relmse(fine-both) < relmse(fine-off)" --claim "relmse(fine-off) / relmse(fine-both) < 0.8 * relmse(without) / relmse(with)" \
	  --claim "stat(with.json:technique.records) / stat(without.json:technique.records) in 1..1" \
	  without.png="without gradients" with.png="with gradients" without-error.svg="relative error, without" with-error.svg="relative error, with"

# Where no record is valid, a path is traced: with few samples per pixel, its noise would hide the error of the cache.
IRR_SMALL = $(BIN)/irrcache $(BOX) $(SMALL) --component indirect --spp $(call q,16,64,64)
figure-13: $(REFERENCES)-small/cornell-box.indirect.exr
	mkdir -p $D
	$(IRR_SMALL) $(LECTURE) --rays 1000 --stats $D/lecture-small.json -o $D/lecture-small.exr
	$(IRR_SMALL) --rays 1000 --stats $D/hessian-small.json -o $D/hessian-small.exr
	$(IRR_OVER) --rays 1000 $(LECTURE) --show records --stats $D/lecture.json -o $D/lecture.exr
	$(IRR_OVER) --rays 1000 --show records --stats $D/hessian.json -o $D/hessian.exr
	$(DRAW) figure $D --slide 13 --columns 2 --title "Cache positions" --reference $< \
	  --caption "Positions of the records with 1000 rays each. Violet and blue records are valid within a small radius, yellow ones within a large one (each picture has its own scale): radii are small in corners and near the blocks. An error estimate with Hessians needs {stat(lecture.json:technique.records) / stat(hessian.json:technique.records)} times fewer. At $(word 2,$(SMALL)) pixels, its {stat(hessian-small.json:technique.records)} records have relMSE {relmse(hessian-small)}, the {stat(lecture-small.json:technique.records)} of the slide's rule {relmse(lecture-small)}: the error differs less than the number of records." \
	  --claim "stat(lecture.json:technique.records) > 2 * stat(hessian.json:technique.records)" --claim "stat(lecture-small.json:technique.records) > 2 * stat(hessian-small.json:technique.records)" \
	  --claim "relmse(hessian-small) / relmse(lecture-small) < stat(lecture-small.json:technique.records) / stat(hessian-small.json:technique.records)" \
	  lecture.records.png="the slide's rule, w > 10: {stat(lecture.json:technique.records)} records" hessian.records.png="error from Hessians with occlusion (the default): {stat(hessian.json:technique.records)} records"

RAYS := $(call q,30 100 300 1000,30 100 300 1000 3000,30 100 300 1000 3000 5000)
ACCURACIES := $(call q,0.1 0.2 0.35 0.5,0.05 0.1 0.2 0.35 0.5,0.05 0.1 0.2 0.35 0.5)
figure-14: $(REFERENCES)-small/cornell-box.indirect.exr
	mkdir -p $D
	for n in $(RAYS); do $(IRR_SMALL) $(LECTURE) --rays $$n -o $D/rays-$$n.exr; done
	for a in $(ACCURACIES); do $(IRR_SMALL) $(LECTURE) --rays 1000 --accuracy $$a -o $D/accuracy-$$a.exr; done
	$(IRR) --rays 30 $(LECTURE) -o $D/few.exr
	$(IRR) --rays $(lastword $(RAYS)) $(LECTURE) -o $D/many.exr
	$(DRAW) measure $D/rays.csv --reference $< $(foreach n,$(RAYS),$n=$D/rays-$n.exr)
	$(DRAW) measure $D/accuracy.csv --reference $< $(foreach a,$(ACCURACIES),$a=$D/accuracy-$a.exr)
	$(DRAW) plot $D/rays.svg --title "Error against rays per record" --x "rays per record" --y "relMSE" --log xy "w > 10"=$D/rays.csv:x:relmse
	$(DRAW) plot $D/accuracy.svg --title "Error against allowed error" --x "allowed error a (records are used where w > 1/a)" --y "relMSE" --log xy "1000 rays"=$D/accuracy.csv:x:relmse
	$(DRAW) figure $D --slide 14 --columns 2 --exposure 2 --title "More rays" \
	  --caption "More rays make better records: from 30 to $(lastword $(RAYS)) rays per record the error falls by a factor of {first(rays.csv:relmse) / last(rays.csv:relmse)}, most of it by the first 1000. With 1000 rays, an allowed error a above 0.1 adds an error of interpolation. From 0.1 down, the noise of the records remains: more records do not help, more rays do." \
	  --claim "last(rays.csv:relmse) < 0.4 * first(rays.csv:relmse)" --claim "first(accuracy.csv:relmse) < 0.6 * last(accuracy.csv:relmse)" \
	  --claim "at(rays.csv:x:relmse, 1000) < 0.5 * (first(rays.csv:relmse) + last(rays.csv:relmse))" \
	  --claim "at(accuracy.csv:x:relmse, 0.2) > 1.2 * at(accuracy.csv:x:relmse, 0.1)" --claim "at(accuracy.csv:x:relmse, 0.05) > 0.7 * at(accuracy.csv:x:relmse, 0.1)" \
	  few.png="30 rays per record" many.png="$(lastword $(RAYS)) rays per record" rays.svg="error against rays" accuracy.svg="error against allowed error"

# ------------------------------------------------------------------ 15 to 20: radiance caching
RAD = $(BIN)/radcache $(GLOSSY) $(RUN) --component indirect --rays $(call q,200,1000,2000) --glossy-rays $(call q,500,2000,4000)
figure-15: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(RAD) --mode rho-e --spp $(call q,8,32,32) -o $D/naive.exr
	$(RAD) --spp $(call q,8,32,32) -o $D/cached.exr
	$(COPY_REFERENCE)
	$(DRAW) figure $D --slide 15 --columns 3 --exposure 2.5 --inset 0.28,0.6,0.3,0.2,2 --title "Glossy surfaces are not a product" --reference $< \
	  --caption "Indirect light on a plastic floor and a copper block. The product of hemispherical reflectance and irradiance ignores the direction of the light: highlights are missing." \
	  --claim "relmse(cached) < 0.8 * relmse(naive)" --claim "spread(naive[0.31 0.44 0.19 0.36]) < 0.6 * spread(reference[0.31 0.44 0.19 0.36])" \
	  --claim "spread(cached[0.31 0.44 0.19 0.36]) > 0.8 * spread(reference[0.31 0.44 0.19 0.36])" \
	  naive.png="rho_hd(w) E, the naive product" cached.png="radiance caching" reference.png="path tracing, the reference"

figure-16: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(RAD) --spp $(call q,8,32,32) -o $D/cached.exr
	$(BIN)/pathtrace $(GLOSSY) $(RUN) --component indirect --spp $(call q,64,128,128) -o $D/paths.exr
	for p in cached paths; do $(DRAW) difference $D/$$p-error.svg $D/$$p.exr --reference $< --most 0.5; done
	$(DRAW) figure $D --slide 16,20 --columns 2 --exposure 2.5 --title "Radiance caching against path tracing" --reference $< \
	  --caption "Indirect light. Caching has smooth, small errors; path tracing has noise. Times and errors are below each picture. The reflection of the silver ball is too sharp for the cache, so the ball is path-traced in both." \
	  --claim "relmse(cached) < relmse(paths)" \
	  cached.png="radiance caching" paths.png="path tracing" cached-error.svg="relative error, cached" paths-error.svg="relative error, paths"

figure-17:
	mkdir -p $D
	$(RAD) --spp $(call q,8,32,32) --cache-out $D/box.cache --stats $D/first.json -o $D/first.exr
	$(RAD) --spp $(call q,8,32,32) --cache-in $D/box.cache --origin=120,380,-680 --target=310,190,280 --stats $D/second.json -o $D/second.exr
	$(DRAW) figure $D --slide 17 --columns 2 --exposure 2.5 --title "View dependence" \
	  --caption "One cache, two views: records store incoming light by direction, and each view evaluates the BRDF for its own direction, so highlights change: the one at the right edge of the copper block has {mean(second[0.506 0.5275 0.054 0.0725]) / mean(first[0.4625 0.64 0.0475 0.07]) %} of its radiance in the second view. The second view adds records only where the first had none: {stat(second.json:technique.records_made)} to the {stat(first.json:technique.records_made)} of the first." \
	  --claim "stat(second.json:technique.records_read) / stat(first.json:technique.records_made) in 1..1" --claim "stat(second.json:technique.records_made) < 0.5 * stat(first.json:technique.records_made)" --claim "stat(second.json:technique.records_made) > 0" --claim "mean(second[0.506 0.5275 0.054 0.0725]) < 0.85 * mean(first[0.4625 0.64 0.0475 0.07])" \
	  first.png="the view that filled the cache" second.png="another view, from the same cache"

ORDERS := $(call q,1 2 4 8,1 2 3 4 6 8 10 12,1 2 3 4 6 8 10 12)
RAD_SMALL = $(BIN)/radcache $(GLOSSY) $(SMALL) --component indirect --rays 500 --glossy-rays $(call q,500,2000,4000) --spp 16
figure-18: $(REFERENCES)-small/cornell-glossy.indirect.exr
	mkdir -p $D
	$(BIN)/radcache $(GLOSSY) --size $(call q,360x200,720x400,1080x600) --quiet --rays 100 --glossy-rays 200 --spp 1 --show basis,brdf -o $D/sh.exr
	for n in $(ORDERS); do $(RAD_SMALL) --order $$n -o $D/order-$$n.exr; done
	$(DRAW) measure $D/order.csv --reference $< $(foreach n,$(ORDERS),$n=$D/order-$n.exr)
	$(DRAW) plot $D/order.svg --title "Error against order" --x "order n (n^2 functions)" --y "relMSE" --log y "spherical harmonics"=$D/order.csv:x:relmse
	$(DRAW) figure $D --slide 18 --columns 3 --title "Incoming radiance in spherical harmonics" \
	  --caption "The basis to l = 4; a rough BRDF times cosine (black) and its expansions of orders 1 to 10 (blue, orange where negative); the error of the picture against the order. The lowest orders are wrong on average (mean green light {at(order.csv:x:ratio_g, 1)} of the truth for order 1, {at(order.csv:x:ratio_g, 2)} for order 2); from order 6 on, the other errors of the cache are larger." \
	  --claim "last(order.csv:relmse) < 0.7 * first(order.csv:relmse)" --claim "at(order.csv:x:ratio_g, 1) < 0.99" --claim "at(order.csv:x:ratio_g, 2) > 1.01" \
	  --claim "last(order.csv:relmse) > 0.7 * at(order.csv:x:relmse, 6)" \
	  sh.basis.png="the basis functions" sh.brdf.png="a BRDF and its expansions" order.svg="error against order"

figure-19: $(REFERENCES)/cornell-glossy.indirect.exr
	mkdir -p $D
	$(BIN)/radcache $(GLOSSY) --size $(OVER_WIDE) --quiet --rays 100 --glossy-rays 200 --spp 1 --show samples -o $D/lobe.exr
	for n in 4 64; do $(BIN)/pathtrace $(GLOSSY) $(RUN) --component indirect --spp $$n -o $D/paths-$$n.exr; done
	$(DRAW) figure $D --slide 19 --columns 3 --title "Monte Carlo with importance sampling" --exposure 2.5 --reference $< \
	  --caption "Directions sampled by the BRDF times the cosine are dense where it is large (blue); those sampled by the cosine alone are not (orange). Each path still samples one direction per bounce: 16 times as many paths have about a quarter of the noise (a sixteenth of the relMSE)." \
	  --claim "relmse(paths-4) / relmse(paths-64) in 8..22" \
	  lobe.samples.png="300 directions by the cosine, and 300 by the BRDF" paths-4.png="4 paths per pixel" paths-64.png="64 paths per pixel"

# ------------------------------------------------------------------ 22 to 32: photon mapping
PHOTONS := $(call q,20000,100000,100000)
# $(call pixel,X,Y,SIDE): a pixel from thousandths of a square picture.
pixel = $(shell echo $$(($(1) * $(3) / 1000)),$$(($(2) * $(3) / 1000)))
SIDE := $(firstword $(subst x, ,$(SIZE)))
# Pixels of the ring's crescent, and of the floor in the glass sphere's caustic.
RING_OVER := $(call pixel,235,480,$(OVER_SIZE))
FLOOR_OVER := $(call pixel,391,917,$(OVER_SIZE))
SPOT := $(call pixel,705,898,$(SIDE))
PM = $(BIN)/photonmap $(SPHERES) $(RUN) --photons $(PHOTONS) --caustic-photons $(PHOTONS)
PM_OVER = $(BIN)/photonmap $(SPHERES) $(OVER) --photons $(PHOTONS) --caustic-photons $(PHOTONS) --spp $(call q,1,4,4)
# $(call drawn,CHANNEL,PICTURE,LAYER,PART): what a drawing over a picture adds to it. The picture below it is darkened.
drawn = ($(1)($(2):$(3)[$(4)]) - 0.35 * $(1)($(2)[$(4)]))
figure-22:
	mkdir -p $D
	$(PM_OVER) --gather direct --show paths -o $D/photons.exr
	$(DRAW) figure $D --slide 22 --columns 1 --title "Photon tracing" \
	  --caption "The first photon paths from the lamp, over the picture: scattered by walls, reflected by the mirror ball, refracted by the glass ball, absorbed. Yellow segments come straight from the lamp, red ones went through glass or mirror only, blue ones were scattered by a wall before." \
	  --claim "$(call drawn,red,photons,Paths,0.42 0.17 0.16 0.1) > 2 * $(call drawn,blue,photons,Paths,0.42 0.17 0.16 0.1)" --claim "$(call drawn,blue,photons,Paths,0.25 0.6 0.15 0.15) > 1.3 * $(call drawn,red,photons,Paths,0.25 0.6 0.15 0.15)" \
	  photons.paths.png="200 photon paths"

figure-23:
	mkdir -p $D
	$(PM_OVER) --gather direct --show photons --stats $D/photons.json -o $D/photons.exr
	$(DRAW) figure $D --slide 23 --columns 1 --title "Photon density" \
	  --caption "Every visible photon of the global map as a dot: their density gives the irradiance. Yellow photons came straight from the lamp, red ones through glass or mirror only, blue ones were scattered by a wall before. So there are no yellow photons on the ceiling, which the lamp does not light." \
	  --claim "stat(photons.json:technique.global_photons) / $(PHOTONS) in 0.95..1.1" --claim "$(call drawn,green,photons,Photons,0.6 0.02 0.3 0.08) < 0.5 * $(call drawn,blue,photons,Photons,0.6 0.02 0.3 0.08)" --claim "$(call drawn,green,photons,Photons,0.3 0.85 0.3 0.1) > $(call drawn,blue,photons,Photons,0.3 0.85 0.3 0.1)" \
	  photons.photons.png="{stat(photons.json:technique.global_photons)} photons"

# The probe reads the irradiance of a map at a point of the floor. The truth at its pixel is pi L / albedo, from paths from the
# light: paths from the eye find the caustic with far more noise.
TRUTH := 3.14159265 * green(truth[0.705 0.898 0.0001 0.0001]) / green(truth:Albedo[0.705 0.898 0.0001 0.0001])
# Squared relative differences of the maps, two by two.
disagree = ((at(probe-1.csv:k:green, $(1)) / at(probe-2.csv:k:green, $(1)) - 1) ^ 2 + (at(probe-3.csv:k:green, $(1)) / at(probe-4.csv:k:green, $(1)) - 1) ^ 2)
figure-24:
	mkdir -p $D
	$(BIN)/pathtrace $(SPHERES) $(RUN) --mode light --spp 64 -o $D/truth.exr
	for s in 1 2 3 4; do $(BIN)/photonmap $(SPHERES) $(RUN) --photons 20000 --caustic-photons 20000 --gather direct --spp 1 --seed $$s --probe $(SPOT) --probe-out $D/probe-$$s.csv -o $D/probe-$$s.exr; done
	$(DRAW) plot $D/estimate.svg --title "The estimate at a point against k" --x "photons of the estimate, k" --y "irradiance, green" --log x --level "truth (light tracing)=$(TRUTH)" \
	  $(foreach s,1 2 3 4,"map $s"=$D/probe-$s.csv:k:green)
	$(DRAW) figure $D --slide 24 --columns 1 --title "Radiance estimate" \
	  --caption "Four photon maps with different seeds, at a bright point of the caustic below the glass ball. Estimates from few photons are noisy: the maps disagree. Estimates from many photons average over a disc that is larger than the caustic: the maps agree, but on a value that is too low." \
	  --claim "$(call disagree,10) > 3 * $(call disagree,1000)" --claim "(at(probe-1.csv:k:green, 20) + at(probe-2.csv:k:green, 20) + at(probe-3.csv:k:green, 20) + at(probe-4.csv:k:green, 20)) / 4 / ($(TRUTH)) in 0.8..1.2" \
	  --claim "mean(truth[0.705 0.898 0.0001 0.0001]) > 0.8 * max(truth:Caustic[0.5 0.8 0.4 0.15])" --claim "at(probe-1.csv:k:green, 1000) < 0.5 * ($(TRUTH))" --claim "at(probe-1.csv:k:green, 1000) / at(probe-2.csv:k:green, 1000) in 0.85..1.15" \
	  estimate.svg="irradiance against the number of photons; dashed: the true value"

figure-25:
	mkdir -p $D
	$(BIN)/photonmap $(SPHERES) $(OVER) --photons $(call q,4000,4000,4000) --caustic-photons 0 --spp 1 --gather direct --show cells --stats $D/tree.json -o $D/tree.exr
	$(DRAW) figure $D --slide 25 --columns 1 --title "The balanced kd-tree" \
	  --caption "The cells of the tree at the floor, seen from above, with their photons; those above the floor are grey. Each split halves the number of photons, so all cells have as many, whatever their size. A photon takes 20 bytes on the slide: float position, power as RGBE, direction as two bytes, the split axis; here {stat(tree.json:technique.global_bytes) / stat(tree.json:technique.global_photons)} with the tree." \
	  --claim "max(tree:Cells.photons) < 1.1 * percentile(tree:Cells.photons, 20)" \
	  --claim "stat(tree.json:technique.global_bytes) / stat(tree.json:technique.global_photons) in 20..21" tree.cells.png="the splits of {stat(tree.json:technique.global_photons)} photons"

# The mirror ball would spread caustic photons over the whole room, so it is diffuse here.
figure-26:
	mkdir -p $D
	sed -e 's|<ref id="mirror"/>|<ref id="white"/>|' -e 's|"meshes/|"$(CURDIR)/scenes/meshes/|' $(SPHERES) > $D/scene.xml
	$(BIN)/photonmap $D/scene.xml $(OVER) --photons $(PHOTONS) --caustic-photons $(PHOTONS) --spp 1 --show photons --stats $D/photons.json -o $D/photons.exr
	$(DRAW) figure $D --slide 26 --columns 2 --title "Two photon maps" \
	  --caption "The global map contains the light that any surface received (the left ball is diffuse here). The caustic map contains only light that the glass ball refracted or reflected: as many photons, dense in one spot, the others reflected over the room." \
	  --claim "stat(photons.json:technique.caustic_photons) > 0.9 * $(PHOTONS)" \
	  --claim "red(photons:Caustic-photons[0.66 0.88 0.1 0.03]) > 4 * red(photons:Caustic-photons)" --claim "red(photons:Photons[0.66 0.88 0.1 0.03]) < 4 * red(photons:Photons)" \
	  photons.photons.png="global map: {stat(photons.json:technique.global_photons)} photons" photons.caustic-photons.png="caustic map: {stat(photons.json:technique.caustic_photons)} photons"

figure-27:
	mkdir -p $D
	$(BIN)/photonmap scenes/ring.xml $(OVER) --photons $(PHOTONS) --caustic-photons $(PHOTONS) --spp $(call q,1,8,16) --show gathering --probe $(RING_OVER) -o $D/ring.exr
	$(PM_OVER) --gather direct --gather-rays 48 --show gathering --probe $(FLOOR_OVER) -o $D/box.exr
	$(DRAW) figure $D --slide 27-28 --columns 2 --title "Caustics at the first bounce, indirect light at the second" \
	  --caption "At the first diffuse surface of an eye path, the caustic map is read (left; red: the last segments of its photons, which come from two places of the ring to the white dot). For the other light, gather rays start there (right; blue), and the global map is read where they end (white dots)." \
	  --claim "red(ring:Caustic-gather[0.15 0.38 0.2 0.17]) > 0.36 * red(ring[0.15 0.38 0.2 0.17])" --claim "ratio(ring:Caustic-gather[0.5 0 0.5 1], ring[0.5 0 0.5 1]) in 0.3499..0.3501" \
	  --claim "max(box:Final-gather[0 0.3 0.15 0.6]) > 0.99" --claim "max(box:Final-gather[0.85 0.3 0.15 0.6]) > 0.99" --claim "max(box:Final-gather[0.15 0.08 0.22 0.1]) > 0.99" --claim "$(call drawn,blue,box,Final-gather,0.2 0.3 0.6 0.3) > 4 * $(call drawn,red,box,Final-gather,0.2 0.3 0.6 0.3)" \
	  ring.caustic-gather.png="photons of a caustic estimate" box.final-gather.png="gather rays to the second bounce"

figure-29: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	$(PM) --gather none --lookup 50 --kernel lecture --spp $(call q,16,64,64) -o $D/density.exr
	$(PM) --gather direct --lookup 50 --kernel lecture --spp $(call q,16,64,64) -o $D/direct.exr
	$(DRAW) figure $D --slide 29-30 --columns 2 --inset 0.14,0.42,0.2,0.2,2 --title "Photon maps seen directly" --reference $< \
	  --caption "{$(PHOTONS)} photons, 50 per estimate, evaluated at the first diffuse surface of an eye path: blotches, and dark rims where the disc of the estimate extends beyond the surface (the left rim of the back wall has {ratio(density[0.215 0.4 0.012 0.2]) %} of its light). With direct light by shadow rays, the error on the back wall is {relmse(density[0.22 0.24 0.5 0.3]) / relmse(direct[0.22 0.24 0.5 0.3])} times smaller; on the ceiling, which has no direct light, it is the same." \
	  --claim "relmse(direct[0.22 0.24 0.5 0.3]) < 0.5 * relmse(density[0.22 0.24 0.5 0.3])" --claim "relmse(direct[0.1 0.02 0.8 0.1]) / relmse(density[0.1 0.02 0.8 0.1]) in 0.8..1.25" --claim "ratio(density[0.215 0.4 0.012 0.2]) < 0.9" --claim "ratio(density[0.4 0.4 0.2 0.2]) in 0.95..1.05" \
	  density.png="all light from the map" direct.png="direct light by shadow rays, the rest from the map"

figure-31: $(REFERENCES)/cornell-spheres.exr
	mkdir -p $D
	$(PM) --spp $(call q,16,64,64) -o $D/gather.exr
	$(BIN)/pathtrace $(SPHERES) $(RUN) --spp $(call q,64,64,64) -o $D/paths.exr
	for p in gather paths; do $(DRAW) difference $D/$$p-error.svg $D/$$p.exr --reference $< --most 0.5; done
	$(DRAW) figure $D --slide 31 --columns 2 --inset 0.02,0.6,0.2,0.2,2 --title "Final gather" --reference $< \
	  --caption "The density is estimated one bounce later: rays from the first diffuse surface average many estimates, so the blotches disappear. Path tracing with as many samples per pixel has {relmse(paths) / relmse(gather)} times the error, nearly all of it noise of indirect light and of caustics, which paths find by chance." \
	  --claim "relmse(gather) < 0.7 * relmse(paths)" --claim "rmse(paths:Indirect, reference:Indirect) ^ 2 + rmse(paths:Caustic, reference:Caustic) ^ 2 > 4 * rmse(paths:Direct, reference:Direct) ^ 2" \
	  gather.png="photon mapping with final gather" paths.png="path tracing" gather-error.svg="relative error, photon mapping" paths-error.svg="relative error, path tracing"

figure-32:
	mkdir -p $D
	$(BIN)/photonmap scenes/cognac.xml -D tint=1,1,1 -D absorption=0.36,2.08,6.37 $(RUN) --photons $(PHOTONS) --caustic-photons $(call q,100000,1000000,1000000) --spp $(call q,16,64,64) -o $D/cognac.exr
	$(DRAW) figure $D --slide 32 --columns 1 --title "A glass of cognac" \
	  --caption "Light through glass and an amber liquid that absorbs: the liquid colours the caustic on the table. The caustic has {red(cognac[0.535 0.71 0.11 0.05]) / blue(cognac[0.535 0.71 0.11 0.05])} times as much red as blue, the table beside it {red(cognac[0.2 0.85 0.2 0.1]) / blue(cognac[0.2 0.85 0.2 0.1])} times." \
	  --claim "red(cognac[0.535 0.71 0.11 0.05]) / blue(cognac[0.535 0.71 0.11 0.05]) > 2 * red(cognac[0.2 0.85 0.2 0.1]) / blue(cognac[0.2 0.85 0.2 0.1])" --claim "mean(cognac[0.535 0.71 0.11 0.05]) > 1.5 * mean(cognac[0.2 0.85 0.2 0.1])" cognac.png="photon mapping, caustic map"

figure-33:
	mkdir -p $D
	$(BIN)/photonmap scenes/pavilion.xml --size $(WIDE) --quiet --photons $(call q,50000,500000,1000000) --caustic-photons $(PHOTONS) --spp $(call q,16,64,64) -o $D/pavilion.exr
	$(DRAW) figure $D --slide 33 --columns 1 --title "A house under the sky" \
	  --caption "Slabs, glass walls, a pool, and a wall of onyx, under sun and sky. Neither sun nor sky shines on the ceiling: {mean(pavilion:Indirect[0.3 0.14 0.25 0.05]) / mean(pavilion[0.3 0.14 0.25 0.05]) %} of its light was reflected before, by pavement, walls and furniture." \
	  --claim "mean(pavilion:Indirect[0.3 0.14 0.25 0.05]) > 0.8 * mean(pavilion[0.3 0.14 0.25 0.05])" pavilion.png="photon mapping with final gather"

# Light inside media: most of the light from the stone was scattered many times inside it.
SOLID = $(BIN)/photonmap --volume-photons $(call q,50000,200000,500000) --volume-lookup $(call q,100,300,800) --photons $(PHOTONS) --spp $(call q,4,16,8)
figure-34:
	mkdir -p $D
	$(SOLID) scenes/marble.xml $(RUN) -o $D/marble.exr
	$(SOLID) scenes/marble.xml $(RUN) --subsurface dipole -o $D/marble-dipole.exr
	$(BIN)/pathtrace scenes/marble.xml $(RUN) --mode volpath --spp $(call q,32,64,128) -o $D/volpath.exr
	$(SOLID) scenes/milk.xml $(RUN) -o $D/milk.exr
	$(SOLID) scenes/milk.xml $(RUN) --subsurface dipole -o $D/milk-dipole.exr
	$(BIN)/photonmap scenes/fog.xml $(RUN) --volume-photons $(call q,100000,500000,500000) --photons $(PHOTONS) --spp $(call q,4,16,8) -o $D/fog.exr
	$(DRAW) figure $D --slide 34 --columns 3 --title "Subsurface scattering" \
	  --caption "Marble lit from behind, milk, and a caustic in mist, from photons stored where the medium scatters them. The dipole treats every point as if it were on a flat half-space: its picture is smooth, but too dark, most of all where the stone is thin and lit from behind (the ring has {ratio(marble-dipole[0.51 0.45 0.08 0.15], volpath) %} of its light). The path tracer's rays leave the polished stone toward the lamp only by luck: its picture is right on average, but noisy." \
	  --claim "ratio(marble-dipole[0.51 0.45 0.08 0.15], volpath) < 0.75" --claim "ratio(marble-dipole[0.51 0.45 0.08 0.15], volpath) < 0.85 * ratio(marble-dipole[0.14 0.7 0.3 0.08], volpath)" \
	  --claim "ratio(marble[0.51 0.45 0.08 0.15], volpath) in 0.85..1.15" --claim "spread(volpath[0.51 0.45 0.08 0.15]) > 2 * spread(marble-dipole[0.51 0.45 0.08 0.15])" \
	  marble.png="marble, photons in the medium" marble-dipole.png="marble, dipole" volpath.png="marble, volumetric path tracing" \
	  milk.png="milk, photons" milk-dipole.png="milk, dipole" fog.png="mist around a glass ball"

# ------------------------------------------------------------------ 35 to 46: progressive photon mapping
figure-35:
	mkdir -p $D
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --spp $(call q,128,192,192) -o $D/paths.exr
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --mode bdpt --spp $(call q,32,48,48) -o $D/bdpt.exr
	$(BIN)/pathtrace scenes/bulb.xml $(RUN) --mode vcm --spp $(call q,32,48,48) -o $D/vcm.exr
	$(BIN)/photonmap scenes/bulb.xml $(RUN) --photons $(PHOTONS) --caustic-photons $(call q,100000,1000000,1000000) --spp $(call q,16,32,32) -o $D/photonmap.exr
	$(BIN)/ppm scenes/bulb.xml $(RUN) --passes $(call q,64,96,96) -o $D/ppm.exr
	$(BIN)/pathtrace $(SPHERES) --size $(OVER_WIDE) --quiet --mode bdpt --show strategies --spp $(call q,8,8,32) -o $D/ways.exr
	$(DRAW) figure $D --slide 35,38 --columns 4 --title "All light is caustic" \
	  --caption "A lamp inside a glass shell: paths from the eye find it only by chance. Through the shell, bidirectional path tracing sees the walls only by chance too; merging finds that light. Times are shown below the pictures. Last: what each way to connect a path finds in a Cornell box. A row per number of segments, 1 to 5; from left to right, 0, 1, 2, ... vertices on the light's side." \
	  --claim "spread(paths[0.1 0.1 0.3 0.3]) > 2 * spread(vcm[0.1 0.1 0.3 0.3])" --claim "spread(paths[0.1 0.1 0.3 0.3]) > 2 * spread(ppm[0.1 0.1 0.3 0.3])" \
	  --claim "spread(bdpt[0.36 0.32 0.08 0.15]) > 3 * spread(vcm[0.36 0.32 0.08 0.15])" --claim "spread(bdpt[0.36 0.32 0.08 0.15]) > 3 * spread(ppm[0.36 0.32 0.08 0.15])" \
	  paths.png="path tracing" bdpt.png="bidirectional path tracing" vcm.png="vertex connection and merging" photonmap.png="photon mapping" ppm.png="progressive photon mapping" \
	  ways.pyramid-unweighted.png="all ways of bidirectional path tracing, not weighted" ways.pyramid.png="weighted: they sum to the picture"

figure-36:
	mkdir -p $D
	$(PM) --spp $(call q,4,16,16) --stats $D/photonmap.json -o $D/photonmap.exr
	$(BIN)/ppm $(SPHERES) $(RUN) --method ppm --passes $(call q,16,64,64) --stats $D/ppm.json -o $D/ppm.exr
	$(DRAW) flow $D/photonmap.svg --title "Photon mapping" --stats $D/photonmap.json \
	  "{technique.global_paths} photon paths,|{technique.caustic_paths} more aimed|at glass and mirror" \
	  "{technique.global_photons} photons stored|and {technique.caustic_photons} for caustics" "kd-trees|{technique.global_bytes} and|{technique.caustic_bytes} bytes" \
	  "{passes} paths per pixel|from the eye|read both maps"
	$(DRAW) flow $D/ppm.svg --title "Progressive photon mapping" --stats $D/ppm.json --again 2,3 \
	  "{size.0} x {size.1} hit points|of paths from the eye|first R {technique.initial_radius_mean} (mean)" "{technique.photon_paths} photon paths|in {passes} passes|none is kept" \
	  "{technique.photons_contributed} contributions|R and tau of every|hit point anew" "L = tau / (pi R^2 n)"
	$(DRAW) figure $D --slide 36-37 --columns 1 --title "Two passes, or many" \
	  --caption "Photon mapping stores all photons, then traces eye paths. Progressive photon mapping traces eye paths once, keeps their hit points, and does not store photons, so there is no limit to their number. The numbers are from real runs." \
	  --claim "stat(ppm.json:technique.photon_paths) > 10 * stat(photonmap.json:technique.global_paths)" \
	  photonmap.svg="photon mapping" ppm.svg="progressive photon mapping"

# N^beta of N photons: with ppa, the radius shrinks so that a fraction alpha of each pass's photons stays; beta = alpha. Two seeds tell
# noise and bias apart. The caustic below the glass ball, from so near that pixels are smaller than the radius: otherwise the mean over
# the pixel hides what the radius does. The first radius is large enough that its bias shows. Theory: noise^2 ~ n^-beta, and
# bias^2 ~ r^4 ~ n^-2(1 - beta).
BETAS := 0.5 0.67 0.8 1
LADDER := $(call q,4 16 64,4 16 64 128,4 16 64 256)
BLOB := $(BIN)/ppm $(SPHERES) --origin 110,150,-60 --target 145,0,160 --fov 16 --size 128x128 --quiet --method ppa --component caustic --photons $(call q,5000,10000,10000)
BLOB_PART := 0.1,0.3,0.8,0.32
figure-39:
	mkdir -p $D
	$(BLOB) --initial-radius 0.012 --alpha 0.67 --seed 7 --passes $(call q,256,1024,4096) -o $D/reference.exr
	for s in 1 2; do for b in $(BETAS); do for n in $(LADDER); do $(BLOB) --initial-radius 0.025 --alpha $$b --seed $$s --passes $$n -o $D/beta-$$b-$$n-$$s.exr; done; done; done
	$(foreach b,$(BETAS),$(DRAW) measure $D/beta-$b.csv --layer Caustic --part $(BLOB_PART) --reference $D/reference.exr $(foreach n,$(LADDER),$n=$D/beta-$b-$n-1.exr$(,)$D/beta-$b-$n-2.exr) &&) true
	$(DRAW) plot $D/noise.svg --title "Noise" --x "passes n (N grows with them)" --y "noise^2, relative" --log xy --slopes $(foreach b,$(BETAS),"beta $b"=$D/beta-$b.csv:x:noise) \
	  --power "theory: n^-1/2=-0.5@1" --power "theory: n^-1=-1@4"
	$(DRAW) plot $D/bias.svg --title "Bias" --x "passes n" --y "bias^2, relative" --log xy --slopes $(foreach b,$(BETAS),"beta $b"=$D/beta-$b.csv:x:bias) \
	  --power "theory: n^-1=-1@1" --power "theory: n^-0.4=-0.4@3" --power "theory: constant=0@4"
	$(DRAW) plot $D/error.svg --title "Error: noise and bias" --x "passes n" --y "relMSE of the caustic" --log xy $(foreach b,$(BETAS),"beta $b"=$D/beta-$b.csv:x:relmse)
	$(DRAW) figure $D --slide 39-40 --columns 3 --title "Noise and bias must shrink together" --layer Caustic \
	  --caption "Of N photons, N^beta are used. Theory: noise^2 falls as n^-beta, bias^2 as r^4 = n^-2(1-beta). With beta = 1 the radius stays constant: its noise falls fastest, but its bias remains, and the error ends there. With beta = 1/2 the bias falls fastest, and the noise slowest. The mean contains the first passes, whose radius is large, so the bias falls later than r^4; the noise falls faster than in theory, because photon paths are stratified, and because the noisy blur round the caustic shrinks (compare the slopes in the legends)." \
	  --claim "last(beta-1.csv:relmse) > 2 * last(beta-0.5.csv:relmse)" --claim "last(beta-1.csv:noise) < last(beta-0.5.csv:noise)" \
	  --claim "slope(beta-1.csv:x:noise) in -1.15..-0.85" --claim "slope(beta-0.5.csv:x:noise) in -0.9..-0.4" --claim "slope(beta-0.5.csv:x:noise) > slope(beta-1.csv:x:noise) + 0.1" \
	  --claim "last(beta-1.csv:bias) > 0.7 * first(beta-1.csv:bias)" --claim "last(beta-0.5.csv:bias) < 0.6 * first(beta-0.5.csv:bias)" --claim "last(beta-0.5.csv:bias) < 0.3 * last(beta-1.csv:bias)" \
	  error.svg="noise and bias together" noise.svg="noise alone" bias.svg="bias alone" \
	  $(foreach b,1 0.5,beta-$b-$(lastword $(LADDER))-1.png="the caustic below the glass ball, beta $b, $(lastword $(LADDER)) passes")

PASSES := $(call q,200,500,1000)
ALPHAS := 0.5 0.7 0.9
# A point of the floor with an even density of photons: in a caustic, the density changes as the disc shrinks.
EVEN := $(call pixel,312,833,$(call q,96,160,256))
figure-41:
	mkdir -p $D
	for a in $(ALPHAS); do $(BIN)/ppm $(SPHERES) $(SMALL) --photons 20000 --passes $(PASSES) --alpha $$a --trace-pixel $(EVEN) --trace-out $D/alpha-$$a.csv -o $D/alpha-$$a.exr; done
	$(BIN)/ppm scenes/ring.xml --size $(call q,128x128,288x288,512x512) --quiet --photons 20000 --passes 100 --alpha 0.7 --show radius -o $D/map.exr
	$(DRAW) plot $D/radius.svg --title "Radius of a hit point" --x "passes n" --y "R (radii of the scene)" --log xy --slopes $(foreach a,$(ALPHAS),"alpha $a"=$D/alpha-$a.csv:pass:radius) \
	  --power "theory: n^-1/4=-0.25@1" --power "theory: n^-0.15=-0.15@2" --power "theory: n^-0.05=-0.05@3"
	$(DRAW) plot $D/photons.svg --title "Number of photons N" --x "passes n" --y "N" --log xy --slopes $(foreach a,$(ALPHAS),"alpha $a"=$D/alpha-$a.csv:pass:N) \
	  --power "theory: n^1/2=0.5@1" --power "theory: n^0.7=0.7@2" --power "theory: n^0.9=0.9@3"
	$(DRAW) figure $D --slide 41-42 --columns 3 --title "Radius reduction" \
	  --caption "R' = R sqrt((N + alpha M) / (N + M)) after every pass: where the density of photons is even, the radius shrinks as n^((alpha - 1) / 2), and N still grows as n^alpha." \
	  --claim "slope(alpha-0.5.csv:pass:radius) in -0.28..-0.19" --claim "slope(alpha-0.7.csv:pass:radius) in -0.18..-0.11" --claim "slope(alpha-0.9.csv:pass:radius) in -0.08..-0.03" \
	  --claim "slope(alpha-0.5.csv:pass:N) in 0.4..0.6" --claim "slope(alpha-0.9.csv:pass:N) in 0.8..1" --claim "slope(alpha-0.7.csv:pass:N) in 0.6..0.8" \
	  --claim "last(alpha-0.5.csv:radius) < last(alpha-0.9.csv:radius)" \
	  radius.svg="R of one hit point on the floor of the Cornell box" photons.svg="N of the same hit point" map.radius.png="the map of R round a ring, for alpha 0.7, after 100 passes: dark is small, where photons are dense"

# $(call passes,N): the number in words.
passes = $(if $(filter 1,$1),1 pass,$1 passes)
STAGES := $(call q,1 10 50,1 10 100,1 10 200)
figure-43:
	mkdir -p $D
	for n in $(STAGES); do $(BIN)/ppm scenes/torus-in-glass.xml $(RUN) --passes $$n -o $D/torus-$$n.exr; $(BIN)/ppm scenes/pool.xml $(RUN) --passes $$n -o $D/pool-$$n.exr; done
	for s in torus pool; do $(BIN)/ppm scenes/$$(echo $$s | sed s/torus/torus-in-glass/).xml $(RUN) --passes $(lastword $(STAGES)) --seed 2 -o $D/$$s-again.exr; done
	$(DRAW) figure $D --slide 43-46 --columns $(words $(STAGES)) --title "The picture over the passes" \
	  --caption "A torus inside glass, and the floor of a pool: all light goes through glass or water on its way there and on its way to the eye. Noise and blur shrink together." \
	  $(foreach s,torus pool,--claim "relmse($s-10:Caustic, $s-again:Caustic) < 0.5 * relmse($s-1:Caustic, $s-again:Caustic)" --claim "relmse($s-$(lastword $(STAGES)):Caustic, $s-again:Caustic) < 0.8 * relmse($s-10:Caustic, $s-again:Caustic)") \
	  $(foreach n,$(STAGES),torus-$n.png="$(call passes,$n)") $(foreach n,$(STAGES),pool-$n.png="$(call passes,$n)")

# ------------------------------------------------------------------ 47 to 52: instant radiosity
VPL = $(BIN)/instant-radiosity $(BOX) $(RUN)
figure-47:
	mkdir -p $D
	for s in 0 1 2 3; do $(VPL) --direct vpl --component direct --vpls 1 --spp 1 --first-pass $$s -o $D/light-$$s.exr; done
	for n in 4 16 64; do $(VPL) --direct vpl --component direct --vpls 1 --spp $$n -o $D/mean-$$n.exr; done
	$(VPL) --component direct --spp 256 -o $D/sampled.exr
	$(DRAW) figure $D --slide 47-48 --columns 4 --inset 0.08,0.5,0.2,0.2,2 --title "Soft shadows as the mean of hard shadows" --reference $D/sampled.exr \
	  --caption "Each picture of the upper row uses one point on the area light, and has hard shadows. Averaging many pictures gives soft shadows, as in the accumulation buffer." \
	  --claim "relmse(mean-64) < 0.3 * relmse(mean-4)" --claim "relmse(mean-4) < relmse(light-0)" \
	  $(foreach s,0 1 2 3,light-$s.png="one light") $(foreach n,4 16 64,mean-$n.png="mean of $n") sampled.png="the lamp's area sampled 256 times"

figure-49:
	mkdir -p $D
	$(BIN)/instant-radiosity $(BOX) $(OVER) --vpls 64 --spp $(call q,2,8,16) --show vpls,connections --pixel $(call pixel,234,859,$(OVER_SIZE)) -o $D/vpls.exr
	$(DRAW) figure $D --slide 49-50 --columns 2 --title "Virtual point lights" \
	  --caption "Every vertex of a light path becomes a point light; shadow rays connect each visible point with all of them. Green rays reach their light, orange ones are occluded. The point at the left receives light from the left wall and the ceiling; the blocks hide the lights at the lower right." \
	  --claim "$(call drawn,green,vpls,Connections,0.1 0.2 0.2 0.5) > 5 * $(call drawn,red,vpls,Connections,0.1 0.2 0.2 0.5)" --claim "$(call drawn,red,vpls,Connections,0.75 0.6 0.25 0.4) > 3 * $(call drawn,green,vpls,Connections,0.75 0.6 0.25 0.4)" \
	  vpls.vpls.png="where the lights of 64 paths are" vpls.connections.png="shadow rays of one point"

# 16 passes with N/16 lights each give N lights. With 4096 lights, full would take half an hour more.
COUNTS := 64 1024 $(call q,,4096,)
CLAMPS := 0.1 0.3 1 3 10 30 100 1000
KINDS := unclamped clamped compensated spheres
MOST := $(lastword $(COUNTS))
# The back wall's left end, and the front of the small block.
CORNER := [0.2 0.3 0.02 0.4]
FRONT := [0.5 0.68 0.2 0.08]
SETS := $(call q,4,16,16)
ONE_SET = $(VPL) --component indirect --spp $(SETS)
figure-51: $(REFERENCES)/cornell-box.indirect.exr
	mkdir -p $D
	for n in $(COUNTS); do \
	  $(ONE_SET) --vpls $$((n / $(SETS))) --clamp inf -o $D/unclamped-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(SETS))) --compensation none -o $D/clamped-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(SETS))) -o $D/compensated-$$n.exr; \
	  $(ONE_SET) --vpls $$((n / $(SETS))) --vsl -o $D/spheres-$$n.exr; \
	  for k in $(KINDS); do $(DRAW) difference $D/$$k-$$n.svg $D/$$k-$$n.exr --reference $< --most 0.5; done; \
	done
	for c in $(CLAMPS); do $(BIN)/instant-radiosity $(BOX) $(SMALL) --component indirect --vpls 1024 --spp 1 --clamp $$c --compensation none -o $D/clamp-$$c.exr; done
	$(BIN)/instant-radiosity $(BOX) $(SMALL) --component indirect --vpls 1024 --spp 1 --clamp inf -o $D/whole.exr
	$(DRAW) measure $D/clamp.csv --reference $D/whole.exr $(foreach c,$(CLAMPS),$c=$D/clamp-$c.exr)
	$(DRAW) plot $D/clamp.svg --title "Remaining light" --x "bound of the geometry term (1 / squared scene radius)" --y "clamped / unclamped, mean" --log x "1024 lights (green channel)"=$D/clamp.csv:x:ratio_g
	$(DRAW) figure $D --slide 51-52 --columns 4 --exposure 2 --title "Instant radiosity: bright spots, and remedies" --reference $< \
	  --caption "Indirect light from more and more lights. Without a bound, every light causes a bright spot near itself. With a bound, corners are too dark ($(MOST) lights: {ratio(clamped-$(MOST)$(CORNER)) %} of the light at the left end of the back wall). Paths restore the light that was cut off (compensated: {ratio(compensated-$(MOST)$(CORNER)) %}). Lights as spheres blur instead. With only 64 lights they are so large that the picture is dark ({ratio(spheres-64) %} of the light). More lights make it right on average ({ratio(spheres-$(MOST)) %}), but light leaks round edges: the front of the small block has {ratio(spheres-$(MOST)$(FRONT))} times its light." \
	  --claim "ratio(clamped-1024, unclamped-1024) < 0.99" --claim "ratio(compensated-1024, unclamped-1024) in 0.95..1.05" --claim "ratio(spheres-64, unclamped-64) < 0.95" --claim "ratio(spheres-$(MOST), unclamped-$(MOST)) > ratio(spheres-64, unclamped-64)" \
	  --claim "max(unclamped-64) > 3 * max(compensated-64)" --claim "relmse(unclamped-$(MOST)) > 3 * relmse(clamped-$(MOST))" --claim "ratio(clamped-$(MOST)$(CORNER)) < 0.95 * ratio(compensated-$(MOST)$(CORNER))" \
	  --claim "ratio(spheres-$(MOST)$(FRONT)) > 1.3" --claim "ratio(compensated-$(MOST)$(FRONT)) in 0.8..1.25" --claim "last(clamp.csv:ratio_g) > first(clamp.csv:ratio_g)" \
	  $(foreach n,$(COUNTS),$(foreach k,$(KINDS),$k-$n.png="$n lights: $k" )) \
	  $(foreach k,$(KINDS),$k-$(MOST).svg="$(MOST) lights: error, $k" ) \
	  clamp.svg="light that remains, against the bound"

# ------------------------------------------------------------------ 53 to 62: lightcuts
CUTS = $(BIN)/lightcuts
# Numbers of points on light sources; as many again are on surfaces. All lights are used for the smaller numbers only.
MANY := 10 30 100 300 1000 3000 10000 $(call q,,100000,100000)
MORE := $(call q,100000,1000000,1000000)
# Passes: few lights take so little time that a single pass would be noisy.
REPEATED = --spp $$((n < 1000 ? 64 : n < 10000 ? 16 : n < 100000 ? 2 : 1))
OUTDOORS = --size $(call q,128x96,320x240,800x600) --quiet --rule cluster --lights $(call q,1000,5000,5000) --vpls $(call q,1000,5000,10000) --spp $(call q,2,4,2)
IN_GALLERY = $(CUTS) scenes/gallery.xml --size 32x24 --quiet --rule cluster --max-cut 1000000 --compensation none
# Of the time of the largest number of lights, the part before the first pixel.
PREPARING = stat(cuts-$(lastword $(MORE)).json:seconds.prepare) / (stat(cuts-$(lastword $(MORE)).json:seconds.prepare) + stat(cuts-$(lastword $(MORE)).json:seconds.render))
CROSSOVER := crossing(cuts.csv:x:pass_seconds, all.csv:x:pass_seconds)
figure-53:
	mkdir -p $D
	$(CUTS) scenes/patio.xml $(OUTDOORS) -o $D/patio.exr
	$(CUTS) scenes/patio.xml -D sun=0 $(OUTDOORS) -o $D/sky.exr
	for n in $(MANY); do $(IN_GALLERY) $(REPEATED) --method all --lights $$n --vpls $$n -o $D/all-$$n.exr; done
	for n in $(MANY) $(MORE); do $(IN_GALLERY) $(REPEATED) --lights $$n --vpls $$n --stats $D/cuts-$$n.json -o $D/cuts-$$n.exr; done
	$(DRAW) measure $D/all.csv --reference $D/all-$(lastword $(MANY)).exr $(foreach n,$(MANY),$n=$D/all-$n.exr)
	$(DRAW) measure $D/cuts.csv --reference $D/all-$(lastword $(MANY)).exr $(foreach n,$(MANY) $(MORE),$n=$D/cuts-$n.exr)
	$(DRAW) plot $D/cost.svg --title "Cost against the number of lights" --x "points on light sources, and as many on surfaces" --y "seconds for a picture of 32 x 24" --log xy --slopes \
	  --vertical "crossover at {$(CROSSOVER)}=$(CROSSOVER)" "lightcuts"=$D/cuts.csv:x:pass_seconds "all lights"=$D/all.csv:x:pass_seconds
	$(DRAW) figure $D --slide 53-54 --columns 3 --title "Many lights of all kinds" \
	  --caption "Sun, sky and indirect light as one set of point lights. The curves are of the gallery: the cost of using all lights becomes linear in their number; the cost of cuts grows more slowly. At the right end, {$(PREPARING) %} of their time goes into the points and their trees, which is linear too. Cuts pay off from about {$(CROSSOVER)} points on light sources, and as many on surfaces." \
	  --claim "last(all.csv:pass_seconds) > 3 * at(cuts.csv:x:pass_seconds, $(lastword $(MANY)))" --claim "slope(cuts.csv:x:pass_seconds) < 0.8 * slope(all.csv:x:pass_seconds)" --claim "$(CROSSOVER) in 20..2000" --claim "$(PREPARING) > 0.5" \
	  patio.png="sun, sky and indirect light" sky.png="sky and indirect light" cost.svg="seconds against lights"

GALLERY = $(CUTS) scenes/gallery.xml --size $(call q,320x240,640x480,1024x768) --quiet --rule cluster --lights $(call q,256,1024,1024) --vpls $(call q,1000,4096,16384) --spp 1
# The fraction of the clusters of 2 to 8 lights that are at most 1.8 wide.
NARROW = within(tree.csv:lights:extent, 2 8 0 1.8) / within(tree.csv:lights:lights, 2 8 2 8)
figure-55:
	mkdir -p $D
	$(GALLERY) --show clusters --tree-out $D/tree.csv -o $D/gallery.exr
	$(DRAW) figure $D --slide 55-56 --columns 2 --title "Clusters of lights" \
	  --caption "Lights that are near each other and emit in similar directions are joined to clusters. The lights are drawn over the picture, coloured by cluster, at four levels of the light trees: neighbours of one colour are one cluster. With many clusters, colours repeat. Clusters are narrow: {$(NARROW) %} of those of 2 to 8 lights are within a tenth of the gallery's diagonal, {most(tree.csv:extent)}." \
	  --claim "$(NARROW) > 0.8" --claim "most(tree.csv:extent) in 17..19" \
	  $(foreach n,2 8 32 128,gallery.clusters-$n.png="$n clusters per tree")

figure-57:
	mkdir -p $D
	$(CUTS) scenes/gallery.xml -D lights=4 --size $(OVER_WIDE) --quiet --rule cluster --error 0.1 --lights 16 --component direct --spp $(call q,4,16,16) --tree-out $D/tree.csv -o $D/tree.exr
	$(DRAW) tree $D/tree.svg --table $D/tree.csv
	$(DRAW) figure $D --slide 57-58 --columns 2 --title "A light tree, and a cut" \
	  --caption "A tree of 16 lights, and the cut that was chosen for the pixel in the middle (orange): every light is in exactly one of its {within(tree.csv:in_cut:in_cut, 1 16 1 16)} clusters. Some lights are used one by one, others together." \
	  --claim "sum(tree.csv:in_cut) in 16..16" --claim "within(tree.csv:in_cut:in_cut, 1 1 1 1) > 0" --claim "within(tree.csv:in_cut:in_cut, 2 16 2 16) > 0" \
	  tree.svg="the tree with its cut" tree.png="the scene"

figure-59:
	mkdir -p $D
	$(CUTS) scenes/gallery.xml -D lights=4 --size $(OVER_WIDE) --quiet --lights 4 --fixed-lights --component direct --spp 4 --show cuts --cuts-out $D/cuts.csv -o $D/four.exr
	$(DRAW) cuts $D/cuts.svg --table $D/cuts.csv --prefix $D/four.cut 0 1 2 3
	$(DRAW) figure $D --slide 59-60 --columns 1 --title "Four lights, and their cuts" \
	  --caption "The exact picture, and pictures of three cuts, in which a light represents others. On the back wall, the cut that joins lights 3 and 4 has an error of {mean(four:Cut-1.Error[0.45 0.3 0.1 0.1]) %}, and the cut that joins 1 and 2 of {mean(four:Cut-2.Error[0.45 0.3 0.1 0.1]) %}. On the floor at the left it is the other way round: {mean(four:Cut-1.Error[0.2 0.6 0.1 0.1]) %} and {mean(four:Cut-2.Error[0.2 0.6 0.1 0.1]) %}. So each point gets its own cut." \
	  --claim "mean(four:Cut-1.Error[0.45 0.3 0.1 0.1]) in -0.05..0.05" --claim "mean(four:Cut-2.Error[0.45 0.3 0.1 0.1]) > 0.4" \
	  --claim "mean(four:Cut-1.Error[0.2 0.6 0.1 0.1]) < -0.2" --claim "mean(four:Cut-2.Error[0.2 0.6 0.1 0.1]) in -0.05..0.05" \
	  --claim "at(cuts.csv:cut:mean_error, 3) > at(cuts.csv:cut:mean_error, 1)" --claim "at(cuts.csv:cut:mean_error, 3) > at(cuts.csv:cut:mean_error, 2)" \
	  cuts.svg="four lights, three cuts, their trees and errors"

figure-61:
	mkdir -p $D
	$(GALLERY) --show cut-size --bounds-out $D/bounds.csv -o $D/gallery.exr
	$(DRAW) plot $D/bounds.svg --title "Bound against true error, per cluster" --x "true error / total light" --y "bound / total light" --log xy --scatter --level "largest bound allowed, 2 %=0.02" --power "bound = error=1*1" "a cluster of some pixel's cut"=$D/bounds.csv:error/total:bound/total
	$(DRAW) figure $D --slide 61 --columns 3 --title "Bound the error, refine to 2 %" \
	  --caption "Clusters are refined until the error bound of each one is below 2 % of the total light. The true errors are below their bounds, in the median {median(bounds.csv:bound/error)} times; where bounds are loose, cuts are larger than necessary." \
	  --claim "holds(bounds.csv:error:bound) > 0.999" --claim "most(bounds.csv:bound/total) < 0.0201" --claim "median(bounds.csv:bound/error) > 2" \
	  gallery.png="the picture" gallery.cut-size.png="cut size: dark few clusters, bright many" bounds.svg="bound against error"

figure-62:
	mkdir -p $D
	$(CUTS) scenes/colonnade.xml --size $(WIDE) --quiet --rule cluster --lights $(call q,1000,5000,5000) --vpls $(call q,1000,5000,10000) --spp $(call q,2,4,2) -o $D/colonnade.exr
	$(DRAW) figure $D --slide 62 --columns 1 --title "An atrium by lightcuts" \
	  --caption "Sun and sky fall into an atrium. Of the light on the red drape in the shade (right), {mean(colonnade:Indirect[0.78 0.45 0.05 0.25]) / mean(colonnade[0.78 0.45 0.05 0.25]) %} was reflected by walls, floor and other drapes before." \
	  --claim "mean(colonnade:Indirect[0.78 0.45 0.05 0.25]) > 0.7 * mean(colonnade[0.78 0.45 0.05 0.25])" colonnade.png="lightcuts"

# ------------------------------------------------------------------ the README's picture
# All techniques on one scene at equal time, TECHNIQUES_TIME each: docs/techniques.png. Times differ between runs, and so do the bits.
TECHNIQUES_TIME ?= 60s
TECHNIQUES := pathtrace irrcache radcache photonmap ppm instant-radiosity lightcuts
T := $(FIGURES_OUT)/techniques
techniques: | programs
	mkdir -p $T
	for p in $(TECHNIQUES); do $(BIN)/$$p $(SPHERES) --size 384x384 --quiet --time $(TECHNIQUES_TIME) -o $T/$$p.exr; done
	$(BIN)/pathtrace $(SPHERES) --mode vcm --size 384x384 --quiet --time $(TECHNIQUES_TIME) -o $T/vcm.exr
	$(DRAW) strip docs/techniques.png --columns 4 "irradiance caching"=$T/irrcache.exr "radiance caching"=$T/radcache.exr \
	  "photon mapping"=$T/photonmap.exr "progressive photon maps"=$T/ppm.exr "instant radiosity"=$T/instant-radiosity.exr \
	  "lightcuts"=$T/lightcuts.exr "path tracing"=$T/pathtrace.exr "paths from both ends (vcm)"=$T/vcm.exr

# ------------------------------------------------------------------ classic mistakes
# The programs do not have these mistakes; the crate scripts/mistakes makes them on purpose. The right way is checked against the
# path tracer, and each mistake against the factor that theory gives, where there is one.
MISTAKES := factor cosine stored behind radius spots roulette adjoint
WRONG := scripts/mistakes/scenes
M = $(FIGURES_OUT)/mistakes/$(@:mistake-%=%)
SHAM = $(BIN)/mistakes
SHAM_SIZE := $(call q,96,256,512)
SHAM_RUN = --size $(SHAM_SIZE)
# $(call truth,SCENE,FLAGS): the path tracer's picture, as the reference and as a panel.
define truth
$(BIN)/pathtrace $(1) $(TRUTH_RUN) $(2) -o $M/reference.exr
	cp $M/reference.png $M/truth.png && cp $M/reference.exr $M/truth.exr
endef
TRUTH_RUN = --size $(SHAM_SIZE)x$(SHAM_SIZE) --quiet --spp $(call q,256,1024,1024)
.PHONY: $(MISTAKES:%=mistake-%)
$(MISTAKES:%=mistake-%): | programs

# Draw classic mistakes beside the right way, with their ratios to the truth: out/figures/mistakes/index.html.
mistakes: $(MISTAKES:%=mistake-%)
	$(DRAW) index $(FIGURES_OUT)/mistakes/index.html --title "Classic mistakes" $(MISTAKES:%=$(FIGURES_OUT)/mistakes/%)
	$(DRAW) deck $(FIGURES_OUT)/mistakes/deck.html --title "Classic mistakes" $(MISTAKES:%=$(FIGURES_OUT)/mistakes/%)
	@echo "$(FIGURES_OUT)/mistakes/index.html $(FIGURES_OUT)/mistakes/deck.html"

mistake-factor:
	mkdir -p $M
	for w in direct no-pi pi-twice; do $(SHAM) $$w $(BOX) $(SHAM_RUN) --spp $(call q,16,64,64) -o $M/$$w.exr; done
	$(BIN)/pathtrace $(BOX) $(TRUTH_RUN) --component direct -o $M/reference.exr
	$(DRAW) figure $M --slide Mistake-1 --columns 3 --exposure -1 --title "1/pi forgotten, or counted twice" --part 0,0.3,1,0.7 --reference $M/reference.exr \
	  --caption "A diffuse BRDF is albedo / pi. Without 1/pi, direct light is pi times too bright at every point; with it twice, as when a cosine-weighted direction has already divided by it, pi times too dark. The picture looks plausible: only a comparison shows it." \
	  --claim "ratio(direct[0 0.3 1 0.7]) in 0.98..1.02" --claim "ratio(no-pi[0 0.3 1 0.7], direct[0 0.3 1 0.7]) in 3.1415..3.1417" --claim "ratio(pi-twice[0 0.3 1 0.7], direct[0 0.3 1 0.7]) in 0.3182..0.3184" \
	  direct.png="right: albedo / pi" no-pi.png="1/pi forgotten: {ratio(no-pi[0 0.3 1 0.7], direct[0 0.3 1 0.7])} times the truth" pi-twice.png="1/pi twice: {ratio(pi-twice[0 0.3 1 0.7], direct[0 0.3 1 0.7])} times the truth"

mistake-cosine:
	mkdir -p $M
	for w in direct no-cosine cosine-twice; do $(SHAM) $$w $(BOX) $(SHAM_RUN) --spp $(call q,16,64,64) -o $M/$$w.exr; done
	for w in no-cosine cosine-twice; do $(DRAW) difference $M/$$w-error.svg $M/$$w.exr --reference $M/direct.exr --most 1; done
	$(DRAW) figure $M --slide Mistake-2 --columns 3 --title "The cosine forgotten, or counted twice" --part 0,0.3,1,0.7 --reference $M/direct.exr \
	  --caption "Light that arrives at an angle is spread over more surface, so it counts with the cosine, once. The error depends on the angle: it is small where light falls straight onto the floor, and large where it grazes the front of the tall block." \
	  --claim "ratio(no-cosine[0.15 0.88 0.25 0.06]) < 0.7 * ratio(no-cosine[0.33 0.5 0.15 0.2])" --claim "ratio(no-cosine) > 1.05" --claim "ratio(cosine-twice) < 0.95" \
	  --claim "ratio(cosine-twice[0.33 0.5 0.15 0.2]) < 0.7 * ratio(cosine-twice[0.15 0.88 0.25 0.06])" \
	  direct.png="right" no-cosine.png="forgotten: {ratio(no-cosine[0 0.3 1 0.7])} times the truth" cosine-twice.png="twice: {ratio(cosine-twice[0 0.3 1 0.7])} times the truth" no-cosine-error.svg="relative error, forgotten" cosine-twice-error.svg="relative error, twice"

PHOTON_RUN = $(SHAM_RUN) --light-paths $(call q,100000,1000000,1000000) --radius $(call q,0.05,0.025,0.025) --spp $(call q,1,4,4)
mistake-stored:
	mkdir -p $M
	for w in density per-stored; do $(SHAM) $$w $(BOX) $(PHOTON_RUN) -o $M/$$w.exr; done
	$(call truth,$(BOX),)
	$(DRAW) figure $M --slide Mistake-3 --columns 3 --title "Photon power divided by stored photons" --part 0,0.3,1,0.7 --reference $M/reference.exr \
	  --caption "The power of the lamp is shared by the paths that were emitted, {said(density, emitted)}. Each path is stored at every diffuse surface that it meets, {said(density, stored)} times in all. Dividing by the number of stored photons gives {ratio(per-stored[0 0.3 1 0.7], density[0 0.3 1 0.7])} of the light, and another factor in every scene." \
	  --claim "ratio(density[0.3 0.7 0.4 0.1]) in 0.93..1.07" --claim "ratio(per-stored[0 0.3 1 0.7], density[0 0.3 1 0.7]) * said(density, stored) / said(density, emitted) in 0.99..1.01" \
	  truth.png="truth" density.png="right: divided by emitted paths" per-stored.png="divided by stored photons: {ratio(per-stored[0 0.3 1 0.7], density[0 0.3 1 0.7])} times"

mistake-behind:
	mkdir -p $M
	for w in density from-behind; do $(SHAM) $$w $(WRONG)/thin-wall.xml $(PHOTON_RUN) -o $M/$$w.exr; done
	$(call truth,$(WRONG)/thin-wall.xml,)
	$(DRAW) figure $M --slide Mistake-4 --columns 3 --title "Photons from behind" --reference $M/reference.exr \
	  --caption "A thin wall with a lamp behind it. Its photons lie as near to the dark side as to the lit one. Without comparing normals, the dark side shines: {ratio(from-behind[0.4 0.35 0.15 0.2])} times the truth." \
	  --claim "ratio(density[0.4 0.35 0.15 0.2]) in 0.3..1.5" --claim "ratio(from-behind[0.4 0.35 0.15 0.2]) > 5" \
	  truth.png="truth" density.png="right: photons of the own side only" from-behind.png="photons of both sides"

mistake-radius:
	mkdir -p $M
	for w in shrinking flux-stays; do $(SHAM) $$w $(BOX) $(SHAM_RUN) --light-paths $(call q,20000,100000,100000) --radius 0.04 --spp $(call q,16,64,64) -o $M/$$w.exr; done
	$(call truth,$(BOX),)
	$(DRAW) figure $M --slide Mistake-5 --columns 3 --title "The radius shrinks, its flux does not" --part 0,0.3,1,0.7 --reference $M/reference.exr \
	  --caption "When a progressive radius shrinks, photons of the larger disc lie outside the smaller one: the flux must shrink by the same factor. If it stays, the picture becomes 1/alpha times too bright (alpha = 0.7: 1.43), however many passes are made." \
	  --claim "ratio(shrinking[0.3 0.7 0.4 0.1]) in 0.93..1.07" --claim "ratio(flux-stays[0.3 0.7 0.4 0.1], shrinking[0.3 0.7 0.4 0.1]) in 1.3..1.5" \
	  truth.png="truth" shrinking.png="right: flux times R'^2 / R^2" flux-stays.png="flux stays: {ratio(flux-stays[0.3 0.7 0.4 0.1], shrinking[0.3 0.7 0.4 0.1])} times"

mistake-spots:
	mkdir -p $M
	for w in clamped unclamped; do $(SHAM) $$w $(BOX) $(SHAM_RUN) --light-paths $(call q,64,200,400) --spp $(call q,1,4,4) -o $M/$$w.exr; done
	$(call truth,$(BOX),--component indirect)
	$(DRAW) figure $M --slide Mistake-6 --columns 3 --exposure 2 --title "Virtual lights without a bound" --reference $M/reference.exr \
	  --caption "The geometry term grows without limit near a virtual light, so each light is a bright spot. A bound removes the spots; the light that it cuts off is missing in corners, and must be found in another way." \
	  --claim "max(unclamped) > 3 * max(clamped)" --claim "ratio(clamped) < ratio(unclamped)" \
	  truth.png="truth (indirect light)" clamped.png="bounded: {ratio(clamped)} times the truth" unclamped.png="not bounded: {ratio(unclamped)} times the truth, largest value {max(unclamped) / max(truth)} times"

mistake-roulette:
	mkdir -p $M
	for w in paths biased-roulette; do $(SHAM) $$w $(BOX) $(SHAM_RUN) --spp $(call q,64,512,512) -o $M/$$w.exr; done
	$(call truth,$(BOX),)
	$(DRAW) figure $M --slide Mistake-7 --columns 3 --title "Biased roulette" --part 0,0.3,1,0.7 --reference $M/reference.exr \
	  --caption "Russian roulette ends half of the paths at each bounce after the first. The survivors must count double. If they do not, every further bounce is halved again: the picture is smooth and plausible, but indirect light is missing." \
	  --claim "ratio(paths[0 0.3 1 0.7]) in 0.98..1.02" --claim "ratio(biased-roulette[0 0.3 1 0.7]) < 0.97" \
	  truth.png="truth" paths.png="right: survivors are divided by their probability" biased-roulette.png="not divided: {ratio(biased-roulette[0 0.3 1 0.7])} times the truth"

mistake-adjoint:
	mkdir -p $M
	for w in density no-adjoint; do $(SHAM) $$w $(WRONG)/ball.xml $(SHAM_RUN) --light-paths $(call q,3000000,8000000,8000000) --radius $(call q,0.02,0.015,0.015) --spp $(call q,1,4,4) -o $M/$$w.exr; done
	$(call truth,$(WRONG)/ball.xml,)
	$(DRAW) figure $M --slide Mistake-8 --columns 3 --inset 0.26,0.28,0.25,0.25,2 --title "Photons without the correction for shading normals" --reference $M/reference.exr \
	  --caption "A ball of few triangles with the normals of a sphere. Photons arrive in proportion to the cosine with the real, flat surface. Without the factor |cos(wi, ns)| / |cos(wi, ng)| the triangles show, although the eye's shading is smooth." \
	  --claim "relmse(no-adjoint[0.35 0.25 0.3 0.35]) > 1.3 * relmse(density[0.35 0.25 0.3 0.35])" \
	  truth.png="truth" density.png="right: with the correction" no-adjoint.png="without the correction"
