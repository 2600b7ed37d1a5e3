# The pictures of the pages in docs: options with two values each.
#
#   make pictures
#
# Every picture ends after a number of passes, so that a second run gives the same files.

PICTURES := docs/options
PICTURES_OUT := out/pictures
PICTURE := --size 256x256 --quiet
.PHONY: pictures
# Draw the pictures of the pages in docs: docs/options.
pictures: programs
	mkdir -p $(PICTURES) $(PICTURES_OUT)
	$(call pair,pathtrace-mode,bulb,pathtrace --spp 256 --mode path,--mode path,pathtrace --spp 64 --mode vcm,--mode vcm)
	$(call pair,pathtrace-reuse,cornell-box,pathtrace --spp 7,7 samples per pixel,pathtrace --spp 4 --reuse 8,4 samples and --reuse 8)
	$(call pair,irrcache-rays,cornell-box,irrcache --component indirect --rays 20,--rays 20,irrcache --component indirect,--rays 1000)
	$(call pair,irrcache-accuracy,cornell-box,irrcache --component indirect --error split-sphere --accuracy 0.7 --weights lecture,--accuracy 0.7,irrcache --component indirect --error split-sphere --accuracy 0.1 --weights lecture,--accuracy 0.1)
	$(call pair,radcache-order,cornell-glossy,radcache --component indirect --order 3,--order 3,radcache --component indirect --order 10,--order 10)
	$(call pair,radcache-rays,cornell-glossy,radcache --component indirect --glossy-rays 60,--glossy-rays 60,radcache --component indirect,--glossy-rays 2000)
	$(call pair,photonmap-gather,cornell-spheres,photonmap --gather none,--gather none,photonmap --spp 64,--gather final)
	$(call pair,photonmap-caustic-photons,ring,photonmap --caustic-photons 2000,--caustic-photons 2000,photonmap --caustic-photons 500000,--caustic-photons 500000)
	$(call pair,ppm-passes,torus-in-glass,ppm --passes 4,--passes 4,ppm --passes 400,--passes 400)
	$(call pair,ppm-alpha,ring,ppm --passes 64 --initial-radius 0.02 --alpha 0.4,--alpha 0.4,ppm --passes 64 --initial-radius 0.02 --alpha 1,--alpha 1)
	$(call pair,instant-radiosity-vpls,cornell-box,instant-radiosity --passes 1 --vpls 16 --direct vpl,--vpls 16,instant-radiosity --passes 4 --vpls 4096 --direct vpl,--vpls 4096)
	$(call pair,instant-radiosity-clamp,cornell-box,instant-radiosity --component indirect --vpls 512 --passes 1 --clamp inf --compensation none,--clamp inf,instant-radiosity --component indirect --vpls 512 --passes 1 --clamp 2 --compensation none,--clamp 2)
	$(call pair,lightcuts-error,gallery -D lights=1024,lightcuts --passes 4 --error 0.3 --max-cut 1000 --fixed-lights,--error 0.3,lightcuts --passes 4 --fixed-lights,--error 0.02)

# $(call pair,NAME,SCENE AND ITS PARAMETERS,PROGRAM AND FLAGS,LABEL,PROGRAM AND FLAGS,LABEL): one picture from two.
one = target/release/$(firstword $(2)) scenes/$(firstword $(1)).xml $(wordlist 2,9,$(1)) $(PICTURE) $(wordlist 2,30,$(2)) -o $(PICTURES_OUT)/$(3).exr
define pair
$(call one,$(2),$(3),$(1)-a)
	$(call one,$(2),$(5),$(1)-b)
	target/release/figures strip $(PICTURES)/$(1).png -- "$(4)"=$(PICTURES_OUT)/$(1)-a.exr "$(6)"=$(PICTURES_OUT)/$(1)-b.exr
endef
